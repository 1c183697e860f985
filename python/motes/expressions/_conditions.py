"""Conditions and expressions as trees of plain tuples, compiled into the engine's instructions.

A node is (operation, operand, ...): ("column", name), ("constant", numbers), ("time",), ("inside", shape),
("component", node, index), ("noise", position, time, octaves, field), or an operation and its nodes. Nodes
are immutable, so they can be compared and hashed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .. import _core
from ..errors import ArgumentError

__all__ = [
    "Columns",
    "Condition",
    "Node",
    "Region",
    "Tree",
    "as_condition",
    "checked",
    "columns_of",
    "components",
    "condition_of",
    "program_of",
    "size_of",
    "text_of",
    "zero_divisor_of",
]

Node = tuple[Any, ...]
Step = tuple[str, Any]
Steps = tuple[Step, ...]
"""Instructions as (operation, operand), where the operand of "inside" is still a shape."""
Program = list[tuple[str, int, float]]
"""The engine's instructions."""
Columns = Mapping[str, tuple[int, int]]
"""A system's columns: name -> (first component, width)."""

MOST_STEPS = 256  # operations per expression
EACH = {  # component-wise operations, as scripts write them
    "negate": "-{}",
    "absolute": "abs({})",
    "square_root": "{}.sqrt()",
    "floor": "{}.floor()",
    "invert": "~{}",
    "square": "({} ** 2)",
    "sign": "sign({})",
    "sine": "sin({})",
    "cosine": "cos({})",
    "exponential": "exp({})",
    "logarithm": "log({})",
    "power": "({} ** {})",
    "modulo": "({} % {})",
    "angle": "atan2({}, {})",
    "step": "step({}, {})",
    "mix": "mix({}, {}, {})",
    "smoothstep": "smoothstep({}, {}, {})",
    "choose": "choose({}, {}, {})",
    "add": "({} + {})",
    "subtract": "({} - {})",
    "multiply": "({} * {})",
    "divide": "({} / {})",
    "minimum": "minimum({}, {})",
    "maximum": "maximum({}, {})",
    "less": "({} < {})",
    "less_equal": "({} <= {})",
    "greater": "({} > {})",
    "greater_equal": "({} >= {})",
    "equal": "({} == {})",
    "both": "({} & {})",
    "either": "({} | {})",
}
WHOLE = {  # operations on whole vectors
    "length": "{}.length()",
    "dot": "dot({}, {})",
    "cross": "cross({}, {})",
    "normalize": "normalize({})",
}
TURNED = {"greater": "less", "greater_equal": "less_equal"}  # compiled with operands swapped
IDS = ("id", "a.id")
ID_NODES = tuple(("column", name) for name in IDS)
EXACT = 2**24
"""float32 represents all whole numbers up to this one."""
COMPARISONS = ("less", "less_equal", "greater", "greater_equal", "equal")


class Held:
    """Base of shapes and conditions: passes NumPy's functions to expressions and rejects use as a bool."""

    __slots__ = ()

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> Any:
        """Combine conditions with `numpy.logical_and`, `logical_or`, `logical_not` or the operators & | ~."""
        from ._numpy_calls import numpy_ufunc

        return numpy_ufunc(ufunc, method, inputs, keywords)

    def __array_function__(self, function: Any, _: Any, args: Any, keywords: Any) -> Any:
        """Let `numpy.where` build an expression."""
        from ._numpy_calls import numpy_function

        return numpy_function(function, args, keywords)

    def __bool__(self) -> bool:
        """Raise: the truth value differs per particle. Write & | ~ instead of and, or, not."""
        raise ArgumentError(
            "condition", self, "combined with & | ~ and passed to where=, not tested in Python"
        )


class Region(Held):
    """Base of shapes: a region that can contain a particle."""

    __slots__ = ()

    _native: _core.Shape
    """The engine's shape; internal to the package."""


class Tree:
    """Base of conditions and expressions: an immutable tree of operations, which is pickled and shown."""

    __slots__ = ("_node", "_size")

    _node: Node
    _size: int

    def __init__(self, node: Node, size: int = 1) -> None:
        """Wrap a tree; scripts use `column`, and compare its results to get conditions.

        Args:
            node: an operation and its operands.
            size: number of operations in the tree.
        """
        object.__setattr__(self, "_node", node)
        object.__setattr__(self, "_size", checked(size))

    def __setattr__(self, name: str, _: object) -> None:
        """Raise: trees are immutable."""
        kind = type(self).__name__.lower()
        raise AttributeError(f"{kind}s are immutable: {name!r} cannot be assigned")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the tree."""
        return type(self), (self._node, self._size)

    def __repr__(self) -> str:
        """Show the tree as a script writes it."""
        return text_of(self._node)


class Condition(Tree, Held):
    """True or false for each particle; combine conditions with & | ~ and pass them to `where=`."""

    __slots__ = ()

    def __and__(self, other: Any) -> Condition:
        """Both."""
        return _combine("both", self, as_condition("&", other))

    def __or__(self, other: Any) -> Condition:
        """At least one."""
        return _combine("either", self, as_condition("|", other))

    __rand__ = __and__
    __ror__ = __or__

    def __invert__(self) -> Condition:
        """Not."""
        return Condition(("invert", self._node), self._size + 1)

    def __eq__(self, other: object) -> bool:
        """Equal trees."""
        return isinstance(other, Condition) and self._node == other._node

    def __hash__(self) -> int:
        """Hash of the tree."""
        return hash((Condition, self._node))


def as_condition(argument: str, value: Any) -> Condition:
    """Return `value` as a condition; a shape becomes the condition that it contains the particle."""
    if isinstance(value, Condition):
        return value
    if isinstance(value, Region):
        return Condition(("inside", value))
    raise ArgumentError(argument, value, "a shape or a comparison of columns")


def size_of(operation: str, sizes: Sequence[int]) -> int:
    """Return the number of operations per component, given those of the operands' components."""
    size = sum(sizes)
    if operation == "length":
        return 3 * size + 6
    if operation == "normalize":
        return 4 * size + 7
    if operation == "dot":
        return 3 * size + 5
    return 2 * size + 3 if operation == "cross" else size + 1


def checked(size: int) -> int:
    """Return the number of operations; raise if an expression may not have that many."""
    if size > MOST_STEPS:
        raise ArgumentError("expression", f"{size} operations", f"of at most {MOST_STEPS} operations")
    return size


def text_of(node: Node) -> str:
    """Show a tree as a script writes it."""
    operation, *operands = node
    if operation == "column":
        name = operands[0]
        return name.removeprefix("pair.") if "." in name else f"column({name!r})"
    if operation == "constant":
        numbers = operands[0]
        return repr(numbers[0] if len(numbers) == 1 else numbers)
    if operation == "inside":
        return repr(operands[0])
    if operation == "component":
        return f"{text_of(operands[0])}[{operands[1]}]"
    if operation == "vector":
        return f"({', '.join(map(text_of, operands))})"
    if operation == "time":
        return "time()"
    if operation == "noise":
        at, when, octaves, field = operands
        return f"noise({text_of(at)}, {text_of(when)}, octaves={octaves}, field={field})"
    return (EACH.get(operation) or WHOLE[operation]).format(*map(text_of, operands))


# --- compilation into the engine's instructions


def zero_divisor_of(node: Node) -> str | None:
    """Return the text of the first division by a constant 0 in a tree, or None."""
    operation, *operands = node
    if operation in ("divide", "modulo"):
        divisor, *numbers = operands[1]
        if divisor == "constant" and 0 in numbers[0]:
            return text_of(node)
    trees = [
        operand for operand in operands if isinstance(operand, tuple) and operand and operation != "constant"
    ]
    return next(filter(None, map(zero_divisor_of, trees)), None)


def columns_of(attributes: Iterable[tuple[str, int]]) -> Columns:
    """Return the columns of attributes given as (name, width) pairs, in this order."""
    columns, first = {}, 0
    for name, width in attributes:
        columns[name] = (first, width)
        first += width
    return columns


def components(node: Node, columns: Columns) -> list[Steps]:
    """Return the steps of each of a tree's one or three components."""
    operation, *operands = node
    if operation == "column":
        if operands[0] in IDS:
            return [(("id", 0),)]
        first, width = _column(operands[0], columns)
        return [(("column", first + i),) for i in range(width)]
    if operation == "constant":
        return [(("constant", number),) for number in operands[0]]
    if operation == "inside":
        return [(("inside", operands[0]),)]
    if operation == "component":
        return [_component(operands[0], operands[1], columns)]
    if operation == "time":
        return [(("time", 0),)]
    if operation == "vector":
        return [_component_of_vector(operand, columns) for operand in operands]
    if operation == "noise":
        return [_noise(operands, columns)]
    if operation in WHOLE:
        return _of_vectors(operation, operands, columns)
    if operation in TURNED:
        operation, operands = TURNED[operation], operands[::-1]
    exact = _of_id(operation, operands)
    if exact is not None:
        return [exact]
    parts = _spread(operands, [components(operand, columns) for operand in operands])
    if operation in COMPARISONS and len(parts) != 1:
        compared = f"{text_of(operands[0])} with {text_of(operands[1])}"
        raise ArgumentError("comparison", compared, "of one number per particle: use [0], length()")
    return [sum(steps, ()) + ((operation, 0),) for steps in parts]


def condition_of(where: Any, columns: Columns, shapes: list[_core.Shape]) -> Program:
    """Compile `where` (None: an empty program), appending its shapes to `shapes`."""
    if where is None:
        return []
    return program_of(components(as_condition("where", where)._node, columns)[0], shapes)


def program_of(steps: Steps, shapes: list[_core.Shape]) -> Program:
    """Return the engine's instructions for the steps, appending their shapes to `shapes`."""
    program: Program = []
    for operation, operand in steps:
        if operation == "inside":
            shapes.append(operand._native)
            program.append((operation, len(shapes) - 1, 0.0))
        elif operation == "constant":
            program.append((operation, 0, operand))
        else:
            program.append((operation, operand, 0.0))
    return program


def _combine(operation: str, a: Condition, b: Condition) -> Condition:
    return Condition((operation, a._node, b._node), a._size + b._size + 1)


def _column(name: str, columns: Columns) -> tuple[int, int]:
    given = name
    if name not in columns and name.startswith("a."):  # outside pair laws, `a` is the particle itself
        name = name[2:]
    if name not in columns and "." in name:
        shown = text_of(("column", given))
        raise ArgumentError("expression", shown, "of one particle: only interact() has pairs", known=columns)
    if name not in columns:
        raise ArgumentError("column", name, f"one of {', '.join(columns)}", known=columns)
    return columns[name]


def _of_id(operation: str, operands: Sequence[Node]) -> Steps | None:
    """Return the steps of a remainder or a comparison of ids that needs more digits than float32 has."""
    if operation not in ("modulo", "less", "less_equal", "equal"):
        return None
    turned = operands[1] in ID_NODES
    given, (kind, *numbers) = operands[::-1] if turned else operands
    if given not in ID_NODES or kind != "constant" or len(numbers[0]) != 1:
        return None
    (number,) = numbers[0]
    if operation == "modulo":
        exact = not turned and number.is_integer() and 0 < number <= EXACT
        return (("id", int(number)),) if exact else None
    if not EXACT <= number < EXACT * EXACT:
        return None  # float32 has these numbers, and rounds no id across them
    if turned and operation != "equal":  # c < id is the opposite of id <= c
        opposite = "less_equal" if operation == "less" else "less"
        return (*_id_against(opposite, number), ("invert", 0))
    return _id_against(operation, number)


def _id_against(operation: str, number: float) -> Steps:
    """Compare ids with a number by their upper and lower digits, of base 2^24."""
    high, low = divmod(number, EXACT)
    upper, lower = ("id", -1), ("id", EXACT)
    same = (upper, ("constant", high), ("equal", 0), lower, ("constant", low), (operation, 0), ("both", 0))
    if operation == "equal":
        return same
    return (upper, ("constant", high), ("less", 0), *same, ("either", 0))


def _component(node: Node, index: int, columns: Columns) -> Steps:
    parts = components(node, columns)
    if index >= len(parts):
        raise ArgumentError("index", index, f"0: {text_of(node)} has only one number per particle")
    return parts[index]


def _component_of_vector(node: Node, columns: Columns) -> Steps:
    parts = components(node, columns)
    if len(parts) != 1:
        raise ArgumentError("component", text_of(node), "one number: a vector's components are numbers")
    return parts[0]


def _spread(operands: Sequence[Node], parts: list[list[Steps]]) -> list[tuple[Steps, ...]]:
    """Return the operands' steps per component; a single number is repeated for all components."""
    width = max(map(len, parts))
    return list(zip(*(part * width if len(part) == 1 else part for part in parts), strict=True))


def _three(operation: str, node: Node, columns: Columns) -> list[Steps]:
    parts = components(node, columns)
    if len(parts) != 3:
        raise ArgumentError(operation, text_of(node), "of vectors, not of one number per particle")
    return parts


def _of_vectors(operation: str, operands: Sequence[Node], columns: Columns) -> list[Steps]:
    if operation == "length":  # also defined for one number
        return [_length(components(operands[0], columns))]
    a = _three(operation, operands[0], columns)
    if operation == "normalize":
        return [(*part, *_length(a), ("divide", 0)) for part in a]
    b = _three(operation, operands[1], columns)
    products = {(i, j): (*a[i], *b[j], ("multiply", 0)) for i in range(3) for j in range(3)}
    if operation == "dot":
        return [_total([products[i, i] for i in range(3)])]
    turns = ((1, 2), (2, 0), (0, 1))
    return [(*products[i, j], *products[j, i], ("subtract", 0)) for i, j in turns]


def _length(parts: list[Steps]) -> Steps:
    return (*_total([(*part, ("square", 0)) for part in parts]), ("square_root", 0))


def _total(parts: list[Steps]) -> Steps:
    total = parts[0]
    for part in parts[1:]:
        total = (*total, *part, ("add", 0))
    return total


def _noise(operands: Sequence[Any], columns: Columns) -> Steps:
    position, time, octaves, field = operands
    x, y, z = _three("noise", position, columns)
    when = components(time, columns)
    if len(when) != 1:
        raise ArgumentError("time", text_of(time), "one number per particle")
    return (*x, *y, *z, *when[0], ("noise", octaves * _core.noise_fields + field))
