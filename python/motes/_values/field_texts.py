"""Read the descriptions below a class's fields from its source."""

from __future__ import annotations

import ast
import inspect
import itertools
import textwrap

__all__ = ["with_fields"]


def with_fields(kind: type, text: str) -> str:
    """Return a class's docstring `text` with its public fields' descriptions, if its source is available."""
    try:
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    except (OSError, TypeError, SyntaxError, ValueError):
        return text
    lines = []
    for field, below in itertools.pairwise(getattr(tree, "body", ())):
        description = _text_of(below)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and description:
            if field.target.id.startswith("_"):
                continue  # a note to readers of the source
            lines.append(f"    {field.target.id}: {textwrap.indent(description, ' ' * 8).strip()}")
    fields = "\n".join(lines)
    return f"{inspect.cleandoc(text)}\n\nFields:\n{fields}\n" if lines else text


def _text_of(statement: ast.stmt) -> str:
    value = statement.value if isinstance(statement, ast.Expr) else None
    if isinstance(value, ast.Constant) and isinstance(value.value, str):
        return inspect.cleandoc(value.value)
    return ""
