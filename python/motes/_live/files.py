"""The browser's files: one script and style for the live page and the notebook's widget."""

from __future__ import annotations

from importlib.resources import files

__all__ = ["page", "read"]


def read(name: str, package: str = __package__) -> str:
    """Return the text of a file of this package, or another."""
    return files(package).joinpath(name).read_text(encoding="utf-8")


def page(nonce: str) -> str:
    """Return the live page with its styles and scripts inside; `nonce` marks the scripts that may run."""
    text = read("page.html")
    for name in ("view.css", "view.js", "board.js", "desk.js", "page.js"):
        text = text.replace(f"/*{name.upper()}*/", read(name))
    return text.replace("NONCE", nonce)
