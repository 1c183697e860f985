"""Links to files outside docs/: each such file becomes a page of the site, and the links lead there."""

from __future__ import annotations

import os
import re
from pathlib import Path

from sphinx.application import Sphinx

from _site.pages import DOCS, ROOT, Pages

FOLDER = DOCS / "files"
LINK = re.compile(r"\]\((?![a-z]+:|#)([^)#\s]+)(#[^)\s]*)?\)")
ALWAYS = ("ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md")
INSTEAD = {ROOT / "README.md": DOCS / "index.md"}
LANGUAGES = {".py": "python", ".h": "cpp", ".cpp": "cpp", ".toml": "toml"}
IN_INDEX = ("ARCHITECTURE", "CHANGELOG", "CONTRIBUTING")  # docs/index.md lists these itself


def page_of(path: Path) -> Path:
    """Return the page that stands for a file or a folder outside docs/."""
    if path in INSTEAD:
        return INSTEAD[path]
    name = path.relative_to(ROOT)
    if path.is_dir():
        return FOLDER / name / "index.md"
    return FOLDER / (name if name.suffix == ".md" else f"{name}.md")


def outside(text: str, folder: Path) -> set[Path]:
    """Return the existing files outside docs/ that a text in `folder` links to."""
    targets = {(folder / path).resolve() for path, _ in LINK.findall(text)}
    return {path for path in targets if path.exists() and path.is_relative_to(ROOT) and not _inside(path)}


def relinked(text: str, folder: Path, place: Path) -> str:
    """Rewrite the links of a text from `folder` for a page in `place`, to lead to the site's pages."""

    def one(link: re.Match[str]) -> str:
        target = (folder / link[1]).resolve()
        if not target.exists() or not target.is_relative_to(ROOT):
            return link[0]  # Sphinx reports the broken link
        page = target if _inside(target) else page_of(target)
        fragment = link[2] if link[2] and target not in INSTEAD else ""
        return f"]({os.path.relpath(page, place)}{fragment})"

    return LINK.sub(one, text)


def _inside(path: Path) -> bool:
    return path.is_relative_to(DOCS)


def _sources() -> list[Path]:
    own = [path for suffix in ("md", "ipynb") for path in DOCS.rglob(f"*.{suffix}")]
    generated = (FOLDER, DOCS / "reference", DOCS / "_site")
    return [path for path in own if not any(path.is_relative_to(folder) for folder in generated)]


def _listed(folder: Path) -> list[Path]:
    kept = [path for path in folder.iterdir() if path.is_dir() or path.suffix in {*LANGUAGES, ".md", ".txt"}]
    return sorted(path for path in kept if not path.name.startswith(("_", ".")))


def make() -> Pages:
    """Return a page for each file that a page links to, directly or through other files."""
    pages = Pages(FOLDER)
    waiting = {ROOT / name for name in ALWAYS}
    for path in _sources():
        waiting |= outside(path.read_text(), path.parent)
    done: set[Path] = set(INSTEAD)
    while waiting - done:
        path = min(waiting - done)
        done.add(path)
        page = page_of(path)
        if path.is_dir():
            waiting |= set(_listed(path))
        elif path.suffix == ".md":
            waiting |= outside(path.read_text(), path.parent)
        pages.add(str(page.relative_to(FOLDER)), _text(path, page))
    pages.add("index.md", _index(pages))
    return pages


def _text(path: Path, page: Path) -> str:
    name = path.relative_to(ROOT)
    if path.suffix == ".md":
        return relinked(path.read_text(), path.parent, page.parent)
    if path.is_dir():
        links = [f"- [`{one.name}`]({os.path.relpath(page_of(one), page.parent)})" for one in _listed(path)]
        return "\n".join([f"# `{name}`", "", *links])
    language = LANGUAGES.get(path.suffix, "text")
    file = os.path.relpath(path, page.parent)
    return f"# `{name}`\n\n```{{literalinclude}} {file}\n:language: {language}\n```"


def _index(pages: Pages) -> str:
    names = sorted(str(path.relative_to(FOLDER).with_suffix("")) for path in pages.texts)
    shown = [name for name in names if name not in IN_INDEX]
    return "\n".join(["# Files", "", "Files that these pages link to.", "", "```{toctree}", *shown, "```"])


def write(app: Sphinx) -> None:
    """Write the pages before Sphinx looks for sources."""
    make().write()


def relink(app: Sphinx, docname: str, source: list[str]) -> None:
    """Rewrite the links of a page that has just been read."""
    if docname.partition("/")[0] not in ("files", "reference"):
        folder = (DOCS / docname).parent
        source[0] = relinked(source[0], folder, folder)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the handlers."""
    app.connect("builder-inited", write)
    app.connect("source-read", relink)
    return {"parallel_read_safe": True}
