# make demo and make test do all on a fresh machine; "make help" lists the rest.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DELETE_ON_ERROR:
MAKEFLAGS += --no-print-directory

# Read by tools/find_python.sh when .venv is made.
export PYTHON
# MUMPS and OpenBLAS each start a thread per core: on few cores they get in each other's way.
export OMP_NUM_THREADS ?= 1

# Worker processes of the tests; 0 runs them in pytest's own process.
WORKERS ?= auto
# Further arguments for pytest: make test ARGS='-k layers -x'
ARGS ?=

bin := .venv/bin
stamp := .venv/.complete

# The stamp holds the folder it was written in: a .venv that was moved with its folder, or whose
# Python is gone, does not run.
ifneq ($(file <$(stamp)),$(CURDIR))
$(stamp): FORCE
endif
ifeq ($(realpath $(bin)/python),)
$(stamp): FORCE
endif

.PHONY: help env demo test lint bare format lock clean FORCE

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "make %-8s %s\n", $$1, $$2 }' Makefile

env: $(stamp)  ## fill .venv (PYTHON=... chooses the Python it is made with)
	@:

$(stamp): pyproject.toml constraints.txt
	@sh tools/make_env.sh

demo: $(stamp)  ## modes of a tuning fork: table, picture and files in demo/
	@mkdir -p demo
	@$(bin)/python meshes/tuning_fork.py --size 0.002 --output demo/tuning_fork.msh
	@$(bin)/mesh-to-modes demo/tuning_fork.msh --fixed stem_end --order 2 \
	    --young 2.06e11 --poisson 0.29 --density 7850 --count 12 \
	    --output demo/tuning_fork_modes.npz --vtk demo/tuning_fork_modes.vtu \
	    --picture demo/tuning_fork_modes.png | tee demo/table.txt
	@echo "The demo's files: $(CURDIR)/demo (table.txt, tuning_fork_modes.png, .vtu for ParaView, .npz for NumPy)"

test: $(stamp)  ## all tests (WORKERS=2 for two processes, ARGS='-k name' to choose)
	@$(bin)/python -m pytest --numprocesses $(WORKERS) --maxprocesses 4 --dist loadgroup $(ARGS)

lint: $(stamp)  ## ruff, its formatting, and mypy
	@$(bin)/ruff check .
	@$(bin)/ruff format --check .
	@$(bin)/mypy

bare: $(stamp)  ## install without extras, elsewhere, and run a model there
	@rm -rf .cache/bare
	@$(bin)/uv venv --quiet --python $(bin)/python .cache/bare
	@$(bin)/uv pip install --quiet --python .cache/bare/bin/python \
	    --constraints constraints.txt --build-constraints constraints.txt .
	@$(bin)/python -W error tools/small_model.py .cache/bare/model.npz
	@cd .cache && bare/bin/python -W error -I ../tools/run_model.py bare/model.npz
	@test "$$($(bin)/uv pip list --quiet --python .cache/bare/bin/python --format freeze | wc -l)" = 2
	@echo "a reduced model ran beside NumPy alone"

format: $(stamp)  ## let ruff lay out and sort
	@$(bin)/ruff check --fix-only --quiet .
	@$(bin)/ruff format .

lock: $(stamp)  ## take the newest versions that fit into constraints.txt
	@$(bin)/uv pip compile --quiet --upgrade --universal --python-version 3.12 --all-extras \
	    --no-emit-index-url --custom-compile-command 'make lock' \
	    pyproject.toml --output-file constraints.txt

clean:  ## remove .venv and everything else that make made
	@rm -rf .venv .cache .mypy_cache .pytest_cache .ruff_cache .hypothesis build dist demo docs/_build
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +
