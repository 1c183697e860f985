"""The C++ core for its developers: a page per folder of cpp/, with the comments of each header."""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx

from _site.pages import DOCS, ROOT, Pages, escaped

FOLDER = DOCS / "reference" / "cpp"
CPP = ROOT / "cpp"
OPENING = """
# The C++ core

The comments of the headers in `cpp/`, folder by folder.
[Architecture](../../files/ARCHITECTURE.md) explains how they work together.
[Without Python](../../native.md) shows how a program uses the core.
"""


def opening(text: str) -> str:
    """Return the comment at the head of a header."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        lines.append(line.removeprefix("//").removeprefix(" "))
    return "\n".join(lines)


def declarations(text: str) -> list[tuple[str, str]]:
    """Return what a header declares outside classes, with the `///` comment above it."""
    found = []
    pattern = r"^((?:///.*\n)+)([^/\n}][^;{]*?)(?=[;{]|\n\n)"
    for comment, declared in re.findall(pattern, text, re.MULTILINE):
        said = " ".join(line.removeprefix("///").strip() for line in comment.splitlines())
        found.append((" ".join(declared.split()).split(" : ")[0], said))
    return found


def folders() -> list[Path]:
    """Return the folders that have headers."""
    return sorted({path.parent for path in CPP.rglob("*.h")})


def does(folder: Path) -> str:
    """Return what the table in ARCHITECTURE.md says about a folder."""
    name = re.escape(f"`{folder.relative_to(ROOT)}`")
    row = re.search(rf"^\| {name} \|[^|]*\| (.*) \|$", (ROOT / "ARCHITECTURE.md").read_text(), re.MULTILINE)
    return f"{row[1][0].upper()}{row[1][1:]}." if row else ""


def page(folder: Path) -> str:
    """Return the page of a folder."""
    lines = [f"# `{folder.relative_to(ROOT)}`", "", does(folder)]
    for path in sorted(folder.glob("*.h")):
        text = path.read_text()
        lines += ["", f"## `{path.relative_to(CPP)}`", "", _prose(opening(text)), ""]
        lines += [f"- `{declared}`: {_prose(said)}" for declared, said in declarations(text) if declared]
    return "\n".join(lines)


def _prose(text: str) -> str:
    return escaped(text, "\\*_<>[]#|")


def make() -> Pages:
    """Return all pages."""
    pages = Pages(FOLDER)
    for folder in folders():
        pages.add(f"{folder.relative_to(CPP)}.md", page(folder))
    names = [str(folder.relative_to(CPP)) for folder in folders()]
    pages.add("index.md", "\n".join([OPENING.strip(), "", "```{toctree}", *names, "```"]))
    return pages


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the handlers."""
    app.connect("builder-inited", lambda app: make().write())
    return {"parallel_read_safe": True}
