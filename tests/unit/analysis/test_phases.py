import time

import pytest

from fenics_defo.analysis import Phases


def test_a_phase_entered_again_adds_to_its_time():
    phases = Phases()
    with phases("solve"):
        time.sleep(0.02)
    with phases("count"):
        pass
    first = phases.seconds["solve"]
    with phases("solve"):
        time.sleep(0.02)
    assert first >= 0.02
    assert phases.seconds["solve"] >= first + 0.02
    assert list(phases.seconds) == ["solve", "count"]


def test_a_phase_that_fails_is_timed_and_its_error_passes():
    phases = Phases()
    with pytest.raises(ZeroDivisionError), phases("solve"):
        raise ZeroDivisionError
    assert "solve" in phases.seconds


def test_the_start_of_each_phase_is_announced():
    announced: list[str] = []
    phases = Phases(on_start=announced.append)
    with phases("a"):
        assert announced == ["a"]
        with phases("b"):
            pass
    assert announced == ["a", "b"]


def test_a_phase_within_another_stops_its_clock() -> None:
    phases = Phases()
    begin = time.perf_counter()
    with phases("outer"):
        time.sleep(0.02)
        with phases("inner"), phases("inner"):
            time.sleep(0.05)
    passed = time.perf_counter() - begin
    assert phases.seconds["inner"] >= 0.05
    assert phases.seconds["outer"] >= 0.02
    assert sum(phases.seconds.values()) <= passed
