"""``fenics-defo tradeoff``, and ``reduce`` where the scene says what it requires."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from cli_files import SCENE, Box, strict_json

from fenics_defo import runtime
from fenics_defo.cli import defo
from fenics_defo.scene.trade import driver, timing
from fenics_defo.scene.trade.ladder import Extent

Command = Callable[..., tuple[int, str, str]]

FEW = Extent(
    modes=(6, 20), sizes=(), plain=0, training=(), cubatures=(), factors=(1,), integrators=()
)
TEXT = SCENE.replace("duration = 0.1", "duration = 0.2").replace("young = 1e7", "young = 1e9")


@pytest.fixture(scope="module", autouse=True)
def _short() -> Iterator[None]:
    """Few candidates, whose times need not be good."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timing, "_ROUNDS", 1)
        patch.setattr(timing, "_SECONDS", 0.01)
        patch.setattr(driver, "SMALL", FEW)
        patch.setattr("fenics_defo.cli.tradeoff_run.SMALL", FEW)
        yield


@pytest.fixture
def command(folder: Path, box: Box, capsys: pytest.CaptureFixture[str]) -> Command:
    """Write the scene, run a command in this process, return status, output and errors."""

    def run(*arguments: str, more: str = "") -> tuple[int, str, str]:
        (folder / "scene.toml").write_text(TEXT.format(mesh=box.path) + more)
        status = defo.main(list(arguments))
        return status, *capsys.readouterr()

    return run


TRADE = ("tradeoff", "scene.toml", "--output", "trade", "--small")
LOOSE = "[require]\ntolerance = 0.2\n"
STRICT = "[require]\ntolerance = 1e-9\nrate = 10.0\n"


def test_from_a_scene_to_its_model(command: Command, folder: Path) -> None:
    status, out, err = command(*TRADE, more=LOOSE)
    assert status == 0, err
    for words in (
        "reference: step 0.005 s, its own error about ",
        "on the front",
        "chosen: linear, r = ",
        "written: model.npz, tradeoff.json, tradeoff.csv, tradeoff.png, errors.png,",
    ):
        assert words in out
    names = {path.name for path in (folder / "trade").iterdir()}
    assert names >= {"model.npz", "tradeoff.json", "tradeoff.csv", "tradeoff.png", "report.html"}
    assert runtime.load(folder / "trade" / "model.npz").certificate["scene"]["error"] <= 0.2
    # Once more it is all there; with an impossible wish, none fits.
    status, out, err = command(*TRADE, "--json", more=STRICT)
    assert status == 3
    record = strict_json(out)
    assert record["chosen"] is None
    assert len(record["misses"]) == 3
    assert not (folder / "trade" / "model.npz").exists()
    status, out, _ = command(*TRADE, more=STRICT)
    assert status == 3
    assert "none fits: no model has an error of at most 1e-07 % at 10 steps a second" in " ".join(
        out.split()
    )


def test_reduce_takes_what_the_scene_requires(command: Command, folder: Path) -> None:
    reduce = ("reduce", "scene.toml", "--output", "model.npz")
    status, out, err = command(*reduce, more=LOOSE)
    assert status == 0, err
    assert "chosen: linear, r = " in out
    model = runtime.load(folder / "model.npz")
    assert model.law.kind == "linear"
    assert model.certificate["scene"]["tolerance"] == 0.2
    assert sorted(path.name for path in folder.iterdir()) == ["model.npz", "scene.toml"]
    before = (folder / "model.npz").read_bytes()
    status, out, err = command(*reduce, more=STRICT)
    assert status == 3
    assert "none fits" in out
    assert (folder / "model.npz").read_bytes() == before
    # Options say how the model is made: nothing is measured then.
    status, out, err = command(*reduce, "--modes", "3", "--size", "4", more=STRICT)
    assert status == 0, err
    assert "scene" not in runtime.load(folder / "model.npz").certificate


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("tradeoff", "scene.toml"), "--output"),
        (("tradeoff", "nothing.toml", "--output", "trade"), "nothing.toml"),
        (("tradeoff", "scene.toml", "--output", "scene.toml/trade"), "scene.toml/trade"),
    ],
)
def test_mistakes_are_told_in_a_sentence(
    command: Command, arguments: tuple[str, ...], words: str
) -> None:
    status, out, err = command(*arguments)
    assert (status, out) == (1, "")
    assert err.startswith("fenics-defo")
    assert len(err.splitlines()) == 1
    assert words in err
