"""Selections as text: which kind is meant, what comparisons select, and what mistakes are told."""

import ast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo.errors import SelectionError
from fenics_defo.fem.selection import (
    ComparisonSelection,
    GroupSelection,
    NodeFileSelection,
    equality_tolerance,
    parse_selection,
)
from fenics_defo.fem.selection_grammar import MAX_DEPTH, MAX_LENGTH, parse_comparison

POINTS = np.random.default_rng(0).uniform(-2, 2, (200, 3))
# Exact coordinates too: differences between < and <= show there only.
POINTS = np.concatenate(
    [POINTS, np.array(np.meshgrid([0, 0.5, 1], [-1, 0], [0, 1])).T.reshape(-1, 3)]
)
X, Y, Z = POINTS.T


def select(text, tolerance=1e-9):
    selection = parse_selection(text)
    assert isinstance(selection, ComparisonSelection)
    return selection.evaluate(POINTS, tolerance)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x<1e-6", X < 1e-6),
        ("z>=0.5 and y<0.1", (Z >= 0.5) & (Y < 0.1)),
        ("x < .5 or y <= 0. and z > 1", (X < 0.5) | ((Y <= 0) & (Z > 1))),
        ("(x<.5 or y<=0) and not z>1", ((X < 0.5) | (Y <= 0)) & ~(Z > 1)),
        ("not x<0 and y<0", ~(X < 0) & (Y < 0)),
        ("0<=x<1", (X >= 0) & (X < 1)),
        ("0 < x == 0.5 <= y + 1", (np.abs(X - 0.5) <= 1e-9) & (Y + 1 >= 0.5)),
        ("x**2+y**2 < 1", X**2 + Y**2 < 1),
        ("-x**2 < -1", -(X**2) < -1),
        ("2**-x**2 < 0.5", 2.0 ** -(X**2) < 0.5),
        ("x - y - z > x/2/4*y", X - Y - Z > X / 2 / 4 * Y),
        ("abs(x) > sqrt(y*y)", np.abs(X) > np.sqrt(Y * Y)),
        ("(((x)))<+-(1)", X < -1),
        ("\tx<1\n and y<0 ", (X < 1) & (Y < 0)),
    ],
)
def test_comparisons_select_what_they_say(text, expected):
    assert 0 < expected.sum() < len(POINTS)
    np.testing.assert_array_equal(select(text), expected)


def test_equality_is_within_the_tolerance():
    points = np.zeros((3, 3))
    points[:, 0] = [0.0, 0.9e-6, 1.1e-6]
    selection = parse_selection("x == 0")
    np.testing.assert_array_equal(selection.evaluate(points, 1e-6), [True, True, False])
    np.testing.assert_array_equal(selection.evaluate(points, 0.0), [True, False, False])
    assert equality_tolerance([1, 1, 1], [4, 5, 1]) == pytest.approx(5e-9)


def test_what_has_no_value_fulfils_no_comparison():
    points = np.array([[-1.0, 0, 0], [4.0, 0, 0]])
    np.testing.assert_array_equal(parse_selection("sqrt(x)>1").evaluate(points, 0), [False, True])
    np.testing.assert_array_equal(parse_selection("x/y>1").evaluate(points, 0), [False, True])
    np.testing.assert_array_equal(parse_selection("0/y>=x").evaluate(points, 0), [False, False])


def test_no_points_select_nothing():
    assert parse_selection("x<1").evaluate(np.empty((0, 3)), 0.0).shape == (0,)


# Expression trees written as text with every operation in parentheses, beside their NumPy values.

# Adding zero turns -0.0, whose sign the text would lose, into 0.0.
NUMBERS = (
    st.floats(-3, 3)
    .map(lambda v: v + 0.0)
    .map(lambda v: (f"{abs(v)!r}" if v >= 0 else f"(-{abs(v)!r})", np.float64(v)))
)
LEAVES = NUMBERS | st.sampled_from([("x", X), ("y", Y), ("z", Z)])
ARITHMETIC = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "**": np.power}
ORDER = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal}
LOGIC = {"and": np.logical_and, "or": np.logical_or}


def combined(table, operands):
    return st.builds(
        lambda sign, a, b: (f"({a[0]} {sign} {b[0]})", table[sign](a[1], b[1])),
        st.sampled_from(sorted(table)),
        operands,
        operands,
    )


def called(operands):
    return (
        operands.map(lambda a: (f"abs({a[0]})", np.abs(a[1])))
        | operands.map(lambda a: (f"sqrt({a[0]})", np.sqrt(a[1])))
        | operands.map(lambda a: (f"(-{a[0]})", -a[1]))
    )


SUMS = st.recursive(LEAVES, lambda inner: combined(ARITHMETIC, inner) | called(inner), max_leaves=6)
CONDITIONS = st.recursive(
    combined(ORDER, SUMS),
    lambda inner: (
        combined(LOGIC, inner) | inner.map(lambda a: (f"(not {a[0]})", np.logical_not(a[1])))
    ),
    max_leaves=4,
)


@settings(deadline=None, max_examples=200)
@given(condition=CONDITIONS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_tree_selects_what_numpy_says(condition):
    text, expected = condition
    if not set("xyz") & set(text.replace("sqrt", "")):
        return
    np.testing.assert_array_equal(select(text), np.broadcast_to(expected, len(POINTS)))


# Without parentheses: the tree is the one that Python's parser makes of the same text.

OPERATORS = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}


def value_of(node, coordinates):
    match node:
        case ast.BinOp(left, operator, right):
            function = OPERATORS[type(operator)]
            return function(value_of(left, coordinates), value_of(right, coordinates))
        case ast.UnaryOp(ast.USub(), operand):
            return -value_of(operand, coordinates)
        case ast.Name(axis):
            return coordinates[axis]
        case ast.Constant(number):
            return np.float64(number)


FLAT = st.lists(st.sampled_from(["x", "y", "z", "2", "-x", "0.5"]), min_size=2, max_size=7)


@settings(deadline=None, max_examples=200)
@given(operands=FLAT, data=st.data())
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_precedence_is_pythons(operands, data):
    signs = data.draw(
        st.lists(
            st.sampled_from(["+", "-", "*", "/", "**"]),
            min_size=len(operands) - 1,
            max_size=len(operands) - 1,
        )
    )
    text = operands[0] + "".join(s + o for s, o in zip(signs, operands[1:], strict=True))
    points = np.abs(POINTS) + 0.5
    tree = ast.parse(text, mode="eval").body
    expected = value_of(tree, dict(zip("xyz", points.T, strict=True))) < points[:, 0]
    selected = parse_selection(f"{text}<x").evaluate(points, 0.0)
    np.testing.assert_array_equal(selected, expected)


@settings(deadline=None, max_examples=300)
@given(text=st.text(max_size=40) | st.text("xyz01.e+-*/()<>= andornt'\"", max_size=60))
def test_any_text_is_a_selection_or_a_selection_error(text):
    try:
        selection = parse_selection(text)
    except SelectionError:
        return
    if isinstance(selection, ComparisonSelection):
        assert selection.evaluate(POINTS, 0.0).shape == (len(POINTS),)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x<1 nd y>0", "column 5: unexpected 'nd'; allowed are"),
        ("x=0", "column 2: unexpected '='; write =="),
        ("x != 0", "column 3: unexpected '!='; write not"),
        ("x^2<1", r"column 2: unexpected '\^'; write \*\*"),
        ("x<1 & y<2", "write and"),
        ("X<1", "column 1: unexpected 'X'; .*small letters"),
        ("r<1", "unexpected 'r'; allowed are.*put into quotes"),
        ("x<", "column 3: it ends where a coordinate, a number or a parenthesis is expected"),
        ("(x<1", "column 5: it ends where a closing parenthesis"),
        ("x<1)", r"column 4: unexpected '\)'; expected the end"),
        ("2x<1", "column 2: unexpected 'x'"),
        ("x<1 and y", "column 9: a condition is needed here"),
        ("not x + (y<1)", "a number is needed here"),
        ("(x<1) < 2", "column 1: a number is needed here"),
        ("(x<1)**2 < 2", "column 1: a number is needed here"),
        ("abs(x<1) < 2", "a number is needed"),
        ("abs x<1", r"expected \( after abs"),
        ("1<2", "names none of x, y and z"),
        ("x<1e999", "column 3: the number 1e999 is too large"),
        ("x<1 'left'", "a quoted group name stands alone"),
        ("x<__import__('os')", "unexpected '__import__'"),
        ("x.y<1", "column 2: unexpected '.'"),
        ("x<1;y", "column 4: unexpected ';'"),
        ("", "selection is empty"),
        ("  ", "selection is empty"),
        ("'left", "starts with a quote"),
        ("'left' 'right'", "starts with a quote"),
        ("'", "starts with a quote"),
        ("''", "starts with a quote"),
        ("nodes:", "names no file"),
        (None, "must be a text or a group's number, got None"),
        (True, "got True"),
        (1.5, "got 1.5"),
    ],
)
def test_each_mistake_is_placed_and_explained(text, said):
    with pytest.raises(SelectionError, match=said):
        parse_selection(text)


@pytest.mark.parametrize("opening", ["(", "-", "not ", "2**", "abs(", "not ("])
def test_nesting_is_limited_and_not_by_the_stack(opening):
    with pytest.raises(SelectionError, match=f"nested more than {MAX_DEPTH} deep"):
        parse_selection(opening * (MAX_DEPTH + 1) + "x<1")
    with pytest.raises(SelectionError, match=f"a comparison at most {MAX_LENGTH}"):
        parse_selection(opening * 10**5 + "x<1")


def test_what_is_within_the_limits_is_read():
    deep = "(" * MAX_DEPTH + "x" + ")" * MAX_DEPTH + "<1"
    np.testing.assert_array_equal(select(deep), X < 1)
    long = "+".join(["x"] * 900) + "<1"
    np.testing.assert_array_equal(select(long), 900 * X < 1)
    with pytest.raises(SelectionError, match="nested"):
        parse_comparison("(" + deep + ")")


@pytest.mark.parametrize(
    ("text", "group"),
    [
        ("left", "left"),
        (" left end ", "left end"),
        ("left and right", "left and right"),
        ("x", "x"),
        ("3", 3),
        (3, 3),
        ("'3'", "3"),
        ('"x<1"', "x<1"),
        ("'nodes:a'", "nodes:a"),
        ("'it\"s'", 'it"s'),
        ("3.5", "3.5"),
        ("9" * 100, "9" * 100),
    ],
)
def test_groups(text, group):
    assert parse_selection(text) == GroupSelection(group)


@pytest.mark.parametrize("name", ["x<1", "3", "nodes:a", "'quoted'", " spaced ", "a=b"])
def test_the_exact_name_of_a_group_wins(name):
    assert parse_selection(name, groups={name}) == GroupSelection(name)
    assert parse_selection(f" {name} ", groups={name}).group == name or name != name.strip()


def node_file(tmp_path, content):
    path = tmp_path / "fixed nodes.bou"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    selection = parse_selection(f"nodes:{path}")
    assert selection == NodeFileSelection(path)
    return selection


@pytest.mark.parametrize(
    "content",
    ["1,2,5,11", "11 5\n2\t1\n", "1, 2,\r\n5, 11,\r\n", "\ufeff5 5 011 2 1 1", ",,1 2,5\n\n11,,"],
)
def test_node_files_give_each_number_once_in_order(tmp_path, content):
    numbers = node_file(tmp_path, content).read()
    assert numbers.dtype == np.int64
    np.testing.assert_array_equal(numbers, [1, 2, 5, 11])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "holds no node number"),
        (" ,\n", "holds no node number"),
        ("1,2\n3,x4\n", "line 2: 'x4' is no node number"),
        ("1\n\n0", "line 3: '0'"),
        ("1 -3", "line 1: '-3'"),
        ("1.0", "'1.0'"),
        ("1_0", "'1_0'"),
        ("+1", r"'\+1'"),
        ("٣", "'٣'"),
        ("1;2", "'1;2'"),
        ("9" * 19, "no node number"),
        ("# fixed\n1", "line 1: '#'"),
        (b"1 \xff\xfe\x00", "line 1"),
    ],
)
def test_what_is_no_node_number_is_named_with_its_line(tmp_path, content, said):
    with pytest.raises(SelectionError, match=said) as caught:
        node_file(tmp_path, content).read()
    assert "fixed nodes.bou" in str(caught.value)


def test_a_node_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(SelectionError, match=r"none\.bou cannot be read \(No such file"):
        parse_selection(f"nodes: {tmp_path / 'none.bou'}").read()
    with pytest.raises(SelectionError, match="cannot be read"):
        NodeFileSelection(tmp_path).read()


@given(numbers=st.lists(st.integers(1, 10**18 - 1), min_size=1))
@settings(deadline=None, max_examples=50)
def test_any_list_of_numbers_is_read(tmp_path_factory, numbers):
    path = tmp_path_factory.getbasetemp() / "numbers.txt"
    path.write_text(",".join(map(str, numbers)))
    np.testing.assert_array_equal(NodeFileSelection(path).read(), sorted(set(numbers)))
