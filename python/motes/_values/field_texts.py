"""Read the descriptions below a class's fields from its source."""

from __future__ import annotations

import ast
import inspect
import itertools
import re
import textwrap
from collections.abc import Iterator

__all__ = ["with_fields"]


def with_fields(kind: type, text: str) -> str:
    """Return a class's docstring `text` with its public fields' descriptions, if its source is available.

    Fields of bases are described, too.
    """
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
    lines += _inherited(kind, text)
    fields = "\n".join(lines)
    return f"{inspect.cleandoc(text)}\n\nFields:\n{fields}\n" if lines else text


def _text_of(statement: ast.stmt) -> str:
    value = statement.value if isinstance(statement, ast.Expr) else None
    if isinstance(value, ast.Constant) and isinstance(value.value, str):
        return inspect.cleandoc(value.value)
    return ""


def _inherited(kind: type, text: str) -> Iterator[str]:
    """Yield the lines about fields that a base's docstring describes and `text` does not."""
    for base in kind.__mro__[1:]:
        said = vars(base).get("__doc__")
        said = inspect.cleandoc(getattr(said, "text", said) or "")
        for name in vars(base).get("__annotations__", {}):
            line = re.search(rf"^    {name}: .*(?:\n {{8}}.*)*", said, re.MULTILINE)
            if line and not re.search(rf"^ *{name}: ", text, re.MULTILINE):
                yield line[0]
