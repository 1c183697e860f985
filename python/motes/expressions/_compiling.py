"""Compile expressions into the engine's programs, one per component."""

from __future__ import annotations

from typing import Any

from .. import _core
from ..errors import ArgumentError
from ._conditions import Columns, Program, components, program_of
from ._expression import as_expression, node_of

__all__ = ["compile_values", "components_of"]


def compile_values(
    name: str, value: Any, width: int, columns: Columns, shapes: list[_core.Shape]
) -> list[Program]:
    """Compile the value of an attribute of `width` numbers; a single number fills all components."""
    parts = components_of(name, value, columns, shapes)
    if len(parts) not in (1, width):
        raise ArgumentError(name, value, "a number or an expression of one number per particle")
    return parts * width if len(parts) == 1 else parts


def components_of(name: str, value: Any, columns: Columns, shapes: list[_core.Shape]) -> list[Program]:
    """Compile the one or three components of an expression."""
    return [program_of(part, shapes) for part in components(node_of(as_expression(name, value)), columns)]
