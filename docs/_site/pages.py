"""Pages that a build writes below the folder of the sources, which the history does not keep."""

from __future__ import annotations

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent

LITERAL = re.compile(r"(``.*?``|`[^`]*`)", re.DOTALL)


class Pages:
    """The pages below one folder. What an earlier build wrote, and this one does not, goes away."""

    def __init__(self, folder: Path) -> None:
        """Begin without pages; nothing is written yet."""
        self.folder = folder
        self.texts: dict[Path, str] = {}

    def add(self, name: str, text: str) -> None:
        """Add the page `name`, a path below the folder with its suffix."""
        self.texts[self.folder / name] = text.rstrip("\n") + "\n"

    def write(self) -> None:
        """Write what has changed, so that Sphinx reads nothing else again; remove what is no longer there."""
        for path, text in self.texts.items():
            if not path.is_file() or path.read_text() != text:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
        for path in self.folder.rglob("*"):
            if path.is_file() and path not in self.texts:
                path.unlink()


def escaped(text: str, marks: str) -> str:
    """Put a backslash before each of `marks` outside backticks."""
    parts = LITERAL.split(text)
    parts[::2] = [re.sub(f"([{re.escape(marks)}])", r"\\\1", part) for part in parts[::2]]
    return "".join(parts)
