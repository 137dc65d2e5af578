"""Lists of operations are data: they run as written, and what is not fit to run is refused."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime.operations import OPERATIONS, Machine, OperationList
from fenics_defo.runtime.operations.listing import LONGEST


def listing(steps, *, inputs=2, constants=(), outputs=(-1,)):
    """A list from (name, *operands); outputs may count from the end."""
    total = inputs + len(constants) + len(steps)
    operands = [[*step[1:], *[-1] * (4 - len(step))] for step in steps]
    return OperationList(
        inputs=inputs,
        constants=np.array(constants, float),
        codes=np.array([OPERATIONS[step[0]].code for step in steps], np.int64),
        operands=np.array(operands, np.int64).reshape(-1, 3),
        outputs=np.array([o % total for o in outputs]),
    )


def run(code, *values, parameters=None):
    machine = Machine(code, np.shape(values[0]), parameters or {})
    machine.inputs[:] = values
    return machine.run()


def test_operations_run_in_their_order():
    code = listing([("multiply", 0, 1), ("add", 3, 2), ("square", 4)], constants=[0.5])
    x, y = np.linspace(-1, 1, 7), np.linspace(2, 3, 7)
    np.testing.assert_array_equal(run(code, x, y), [(x * y + 0.5) ** 2])


def test_conditions_choose_and_what_is_not_chosen_may_have_no_value():
    code = listing([("less", 0, 2), ("log", 0), ("where", 3, 1, 4)], constants=[0.0])
    with np.errstate(invalid="ignore"):
        found = run(code, np.array([-1.0, np.e]), np.array([7.0, 7.0]))
    np.testing.assert_allclose(found, [[7.0, 1.0]])


def test_a_machine_runs_again_with_other_inputs_and_keeps_its_parameters():
    code = listing([("exp", 1), ("multiply", 0, 2)])
    machine = Machine(code, (3,), {1: np.array([0.0, 1.0, 2.0])})
    for factor in (1.0, -2.0):
        machine.inputs[:] = factor
        np.testing.assert_allclose(machine.run()[0], factor * np.exp([0.0, 1.0, 2.0]))


def test_outputs_may_be_inputs_constants_or_named_twice():
    code = listing([("add", 0, 1)], constants=[4.0], outputs=(0, 2, 3, 3))
    found = run(code, np.array([1.0, 2.0]), np.array([3.0, 4.0]))
    np.testing.assert_array_equal(found, [[1, 2], [4, 4], [4, 6], [4, 6]])


@settings(max_examples=80, deadline=None)
@given(st.data())
def test_buffers_that_are_used_again_never_lose_a_value_that_is_still_needed(data):
    names = ["add", "subtract", "multiply", "maximum", "negative", "where"]
    steps = []
    for place in range(3, 3 + data.draw(st.integers(1, 30))):
        name = data.draw(st.sampled_from(names))
        known = st.integers(0, place - 1)
        steps.append((name, *(data.draw(known) for _ in range(OPERATIONS[name].arity))))
    total = 3 + len(steps)
    outputs = data.draw(st.lists(st.integers(0, total - 1), min_size=1, max_size=6))
    code = listing(steps, constants=[0.25], outputs=outputs)
    x, y = np.array([0.5, -1.5, 2.0]), np.array([1.0, 0.0, -0.5])
    values = [x, y, np.full(3, 0.25)]
    with np.errstate(all="ignore"):
        for name, *operands in steps:
            taken = [values[o] for o in operands]
            values.append(OPERATIONS[name].function(*taken, out=np.empty(3)))
        fixed = data.draw(st.booleans())
        found = run(code, x, parameters={1: y}) if fixed else run(code, x, y)
    np.testing.assert_array_equal(found, np.array(values)[outputs])


def test_nothing_is_allocated_in_a_run():
    code = listing([("multiply", 0, 1), ("exp", 2), ("divide", 3, 1)])
    machine = Machine(code, (10_000,), {})
    machine.inputs[:] = 0.5
    machine.run()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    machine.run()
    peak = tracemalloc.get_traced_memory()[1] - before
    tracemalloc.stop()
    assert peak < 10_000


def parts(**changes):
    good = listing([("add", 0, 1), ("sqrt", 2)])
    values = {n: getattr(good, n) for n in ("inputs", "constants", "codes", "operands", "outputs")}
    return values | changes


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"codes": [1, 99]}, "operation 99 is not known"),
        ({"codes": [1, -1]}, "operation -1 is not known"),
        ({"operands": [[0, 1, -1], [3, -1, -1]]}, "circles"),
        ({"operands": [[0, 2, -1], [2, -1, -1]]}, "circles"),
        ({"operands": [[0, -1, -1], [2, -1, -1]]}, "not known before"),
        ({"operands": [[0, 1], [2, -1]]}, "shape"),
        ({"outputs": [4]}, "does not exist"),
        ({"outputs": []}, "outputs"),
        ({"constants": [np.nan]}, "finite"),
        ({"inputs": 10**6}, "inputs"),
        ({"codes": [1] * (LONGEST + 1)}, "too long"),
    ],
)
def test_a_list_that_is_not_fit_to_run_is_refused_in_one_sentence(changes, message):
    with pytest.raises(FileFormatError, match=message):
        OperationList(**parts(**changes))


def test_a_list_goes_into_arrays_and_comes_back():
    code = listing([("add", 0, 1), ("multiply", 3, 2)], constants=[2.0])
    again = OperationList.from_arrays(code.arrays())
    values = np.arange(4.0), np.ones(4)
    np.testing.assert_array_equal(run(again, *values), run(code, *values))
    assert not again.codes.flags.writeable


def test_codes_never_change_and_are_all_different():
    codes = [operation.code for operation in OPERATIONS.values()]
    assert codes == list(range(1, 36))
    assert list(OPERATIONS)[:4] == ["add", "subtract", "multiply", "divide"]
