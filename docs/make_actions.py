"""Write docs/actions.md from the docstrings of motes.actions: `python docs/make_actions.py`.

The test of actions compares the file with `page()`, so it cannot fall behind.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from pathlib import Path

from motes import actions, forces, recorder, targets

PAGE = Path(__file__).with_name("actions.md")
FAMILIES = [
    ("What pulls, pushes and turns", forces),
    ("What leads to given values", targets),
    ("What collides, kills and moves", actions),
]
OPENING = """
# Actions

Written by `docs/make_actions.py` from the docstrings of `motes.actions`; change those.

An action acts on each particle alone. In the formulas x is its position in m, v its velocity in m/s, dt the
length of the (sub)step in seconds, unit(y) is y / |y|. Every action takes `where=` too: a shape or a
comparison of columns. `s.gravity(...)` records `motes.actions.Gravity(...)`; all arguments but the first are
keyword-only.

Most actions have the meaning that they have in D. McAllister's Particle System API;
`tests/test_conformance.py` holds them against 108 cases that his library computed. Where ours is another:

| what | cases | ours | his |
|---|---|---|---|
| `sink` with a `Plane` | 4 | it holds the half-space below | it holds the half-space above |
| `bounce` | 10 | at the true place and time of the hit | `exact_hit=False` |
| `gravitate` | 2 | not an action of each particle alone | |

The cases of `sink` with a `Plane` run with `inside` turned round, those of `bounce` with `exact_hit=False`.
Samples of his shapes crowd where ours are uniform, and his generator is another one: what is random is held
against its distribution by `tests/test_actions.py`.
"""


def words(name: str) -> str:
    """Make the method's name of a class's."""
    return re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower()


def wrapped(text: str, indent: str = "") -> str:
    """Fill lines of 120 characters."""
    return textwrap.fill(
        " ".join(text.split()), 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def signature(name: str) -> str:
    """Show the method as it is called, without self and where."""
    parameters = list(inspect.signature(getattr(recorder.Recorder, name)).parameters.values())[1:]
    shown = []
    for p in parameters:
        if p.name == "where":
            continue
        prefix = "**" if p.kind is p.VAR_KEYWORD else ""
        default = "" if p.default is p.empty else f"={p.default}"
        shown.append(f"{prefix}{p.name}{default}")
    return f"{name}({', '.join(shown)})"


def parts(docstring: str) -> tuple[list[str], str, list[tuple[str, str]], str]:
    """Split a docstring: what it does, the formula, the parameters, the source."""
    paragraphs = inspect.cleandoc(docstring).split("\n\n")
    what = [p for p in paragraphs if not p.startswith(("Formula:", "Attributes:", "Source:"))]
    formula, attributes, source = (
        next((p.removeprefix(word).strip() for p in paragraphs if p.startswith(word)), "")
        for word in ("Formula:", "Attributes:", "Source:")
    )
    parameters = [
        (name, text) for name, text in re.findall(r"^\s*(\w+): (.*(?:\n {8}.*)*)", attributes, re.MULTILINE)
    ]
    return what, formula, parameters, source


def section(name: str, kind: type) -> str:
    """Describe one action."""
    what, formula, parameters, source = parts(kind.__doc__ or "")
    lines = [f"### `{signature(name)}`", ""]
    for paragraph in what:
        lines += [wrapped(paragraph), ""]
    lines += [wrapped(f"- formula: {formula}", "  ")]
    lines += [wrapped(f"- `{parameter}`: {text}", "  ") for parameter, text in parameters]
    lines += [wrapped(f"- source: {source}", "  "), ""]
    return "\n".join(lines)


def page() -> str:
    """Return the whole page."""
    overview, sections = ["", "| action | what it does to a particle |", "|---|---|"], [""]
    for title, module in FAMILIES:
        sections += [f"## {title}", ""]
        kinds = [k for k in vars(module).values() if inspect.isclass(k) and k.__module__ == module.__name__]
        for kind in kinds:
            if not issubclass(kind, actions.Action):
                continue
            name = words(kind.__name__)
            overview.append(f"| `{name}` | {' '.join(parts(kind.__doc__ or '')[0][0].split())} |")
            sections.append(section(name, kind))
    opening = [p if p.startswith("|") else wrapped(p) for p in OPENING.strip().split("\n\n")]
    return "\n\n".join(opening) + "\n" + "\n".join(overview) + "\n" + "\n".join(sections).rstrip() + "\n"


if __name__ == "__main__":
    PAGE.write_text(page())
