"""Convert docstrings to reStructuredText: formulas keep their asterisks, names in backticks become links."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import inspect

from _site.pages import LITERAL, escaped
from motes._values.values import FieldTexts

FieldTexts.shown = False  # fields have entries of their own

ARGUMENT = re.compile(r"(?:^|(?<=[.])\s+)(`\w+`):\s+")
NAME = re.compile(r"`([A-Za-z][\w.]*)`")


def markup(lines: list[str]) -> list[str]:
    """Return a docstring's lines as markup; indented blocks after a colon are code."""
    lines = [*lines, "", ""]
    for k, line in enumerate(lines[:-2]):
        code = line.endswith(":") and not lines[k + 1].strip() and indent(lines[k + 2]) > indent(line)
        lines[k] = f"{line.rstrip(':')}::" if code else line
    del lines[-2:]
    made: list[str] = []
    paragraph: list[str] = []
    block: int | None = None  # the indentation of the line before a block of code

    def end_paragraph() -> None:
        text = listed("\n".join(paragraph))
        made.extend(inline(text).split("\n") if text else [])
        paragraph.clear()

    for line in lines:
        indentation = indent(line)
        if block is not None and (not line.strip() or indentation > block):
            made.append(line)
            continue
        block = None
        if line.strip():
            paragraph.append(line)
        if not line.strip() or line.endswith("::"):
            block = indentation if line.endswith("::") else None
            end_paragraph()
            if not line.strip():
                made.append(line)
    end_paragraph()
    return made


def indent(line: str) -> int:
    """Return how far a line is indented."""
    return len(line) - len(line.lstrip())


def listed(text: str) -> str:
    """Turn a paragraph of sentences of the form "`name`: what it is." into a list."""
    if not ARGUMENT.match(text):
        return text
    _, *parts = ARGUMENT.split(text)
    pairs = zip(parts[::2], parts[1::2], strict=True)
    return "\n".join(f"- `{name}`: {' '.join(said.split())}" for name, said in pairs)


def inline(text: str) -> str:
    """Turn single backticks into links or literals, and escape what is neither."""
    parts = LITERAL.split(escaped(text, r"\*|"))
    for k, part in enumerate(parts):
        if not k % 2:
            part = re.sub(r"(\w)_(?!\w)", r"\1\\_", part)
            parts[k] = re.sub(r"(?<!\w)(\w)\.(?=\s|$)", r"\1\\.", part)  # "m." does not begin a list
        elif not part.startswith("``"):
            name = NAME.fullmatch(part)
            parts[k] = f":py:obj:`{name[1]}`" if name else f"``{' '.join(part.strip('`').split())}``"
    return "".join(parts)


def process(app: Sphinx, kind: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Convert a docstring before Napoleon reads its sections; a dataclass's attributes are its arguments."""
    if dataclasses.is_dataclass(thing):
        lines[:] = ["Args:" if line == "Attributes:" else line for line in lines]
    lines[:] = markup(lines)


def arguments(
    app: Sphinx, kind: str, name: str, thing: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str, None] | None:
    """Show the arguments of `__init__` if a class's `__new__` accepts any."""
    if kind != "class" or not str(signature).startswith("(*given"):
        return None
    if thing.__init__ is object.__init__:
        return "()", None
    shown = inspect.signature(thing.__init__, bound_method=True, type_aliases=app.config.autodoc_type_aliases)
    return inspect.stringify_signature(shown, show_return_annotation=False), None


def resolve(app: Sphinx, env: Any, node: Any, contents: nodes.TextElement) -> nodes.reference | None:
    """Resolve names without their module, such as `World`, if exactly one public name matches.

    A single lower-case word is skipped: it is more likely a parameter than a method of another class.
    """
    target = node.get("reftarget", "")
    if node.get("refdomain") != "py" or ("." not in target and target.islower()):
        return None
    known = env.domains["py"].objects
    ends = f".{target}"
    found = [name for name in known if name.endswith(ends)]
    found = [name for name in found if name == f"motes{ends}"] or found
    if len(found) != 1:
        return None
    entry = known[found[0]]
    uri = app.builder.get_relative_uri(node.get("refdoc", env.docname), entry.docname)
    return nodes.reference(
        "", "", contents, internal=True, refuri=f"{uri}#{entry.node_id}", reftitle=found[0]
    )


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the handlers."""
    app.connect("autodoc-process-docstring", process, priority=400)
    app.connect("autodoc-process-signature", arguments)
    app.connect("missing-reference", resolve)
    return {"parallel_read_safe": True}
