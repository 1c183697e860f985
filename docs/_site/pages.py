"""Pages that a build generates below the source folder; they are not under version control."""

from __future__ import annotations

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent

LITERAL = re.compile(r"(``.*?``|`[^`]*`)", re.DOTALL)


class Pages:
    """The pages below one folder. Pages of an earlier build that this one does not write are removed."""

    def __init__(self, folder: Path) -> None:
        """Start without pages."""
        self.folder = folder
        self.texts: dict[Path, str] = {}

    def add(self, name: str, text: str) -> None:
        """Add the page `name`, a path below the folder with its suffix."""
        self.texts[self.folder / name] = text.rstrip("\n") + "\n"

    def write(self) -> None:
        """Write only changed pages, so that Sphinx rereads only these; remove pages that no longer exist."""
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
