"""The compiler's flags follow the processor."""

from pathlib import Path

import pytest

from fenics_defo.fem import jit

OLD = "flags\t\t: fpu sse sse2\n"
NEW = "flags\t\t: fpu sse avx avx2 bmi1 bmi2 f16c fma abm movbe xsave more\n"


@pytest.mark.parametrize(
    ("text", "machine", "expected"),
    [
        (NEW, "x86_64", ("-march=x86-64-v3",)),
        (OLD, "x86_64", ()),
        (NEW + OLD, "x86_64", ()),
        ("model name : some\n", "x86_64", ()),
        (None, "x86_64", ()),
        (NEW, "aarch64", ()),
    ],
)
def test_vectors_where_every_core_has_them(
    text: str | None,
    machine: str,
    expected: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    described = tmp_path / "cpuinfo"
    if text is not None:
        described.write_text(text)
    monkeypatch.setattr(jit, "_CPUINFO", described)
    monkeypatch.setattr(jit.platform, "machine", lambda: machine)
    assert jit.architecture.__wrapped__() == expected


def test_nan_keeps_its_meaning() -> None:
    flags = jit.compiler_flags()
    assert "-ffast-math" not in flags
    assert "-Ofast" not in flags
    assert "-ffinite-math-only" not in flags
