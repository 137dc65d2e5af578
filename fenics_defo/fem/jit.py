"""How forms are compiled: the C compiler's flags, chosen for the machine that runs."""

import platform
from functools import cache
from pathlib import Path

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.core.expr import Expr
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction

from fenics_defo.fem.compat import dolfinx

_CPUINFO = Path("/proc/cpuinfo")
# What the x86-64-v3 level needs beyond the plain one, as Linux names it.
_V3 = {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"}
# Sums may be reordered and contracted, which lets the compiler use vectors; but NaN and infinity
# keep their meaning (unlike -ffast-math), since they are how a collapsed cell is noticed.
_FREE_ORDER = ("-fno-math-errno", "-funsafe-math-optimizations", "-ffp-contract=fast")


@cache
def compiler_flags() -> tuple[str, ...]:
    """Flags of the C compiler for element kernels, which are part of the name they are cached by.

    -O2: -O3 compiles longer, and the kernels it makes are no faster.
    """
    return ("-O2", "-g0", *architecture(), *_FREE_ORDER)


@cache
def architecture() -> tuple[str, ...]:
    """The flag for vectors of four doubles where the processor has them, else none."""
    if platform.machine() not in ("x86_64", "AMD64"):
        return ()
    try:
        lines = _CPUINFO.read_text(encoding="utf-8").splitlines()
    except OSError:
        return ()
    known = [set(line.split(":", 1)[1].split()) for line in lines if line.startswith("flags")]
    if not known or not set.intersection(*known) >= _V3:
        return ()
    return ("-march=x86-64-v3",)


def compiled(form: ufl.Form) -> "dolfinx.fem.Form":
    """A form compiled, or found in DOLFINx's cache; collective."""
    return dolfinx.fem.form(form, jit_options=_options())


def compiled_at_points(expression: Expr, points: NDArray[np.float64]) -> "dolfinx.fem.Expression":
    """An expression without free indices at points (q, 3) of the reference cell; collective.

    It must hold a function of the mesh it will be evaluated on, once it has been differentiated.
    """
    return dolfinx.fem.Expression(expression, points, jit_options=_options())


def differentiated(expression: Expr) -> Expr:
    """The expression with its derivatives carried out, and free of UFL's variables.

    A variable is known by a running number, which becomes part of the name that FFCx keeps a
    compiled expression by: with it, none would ever be found again.
    """
    return map_expr_dag(_WithoutVariables(), apply_derivatives(apply_algebra_lowering(expression)))


class _WithoutVariables(MultiFunction):
    expr = MultiFunction.reuse_if_untouched

    def variable(self, _: Expr, content: Expr, __: Expr) -> Expr:
        return content


def _options() -> dict[str, object]:
    return {"cffi_extra_compile_args": list(compiler_flags())}
