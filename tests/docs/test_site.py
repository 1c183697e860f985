"""The documentation's links work on a forge; the site contains every page and every public name."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import os
import re
import subprocess
import sys
import zlib
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote, urlsplit

import pytest

import motes

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
LINK = re.compile(r"\]\(([^)\s]+)\)")
GENERATED = ("files", "reference")
PACKAGES = ("sphinx", "furo", "myst_nb")
LOOP = "atom"

if not (DOCS / "conf.py").is_file():
    pytest.skip("the pages stand in the source tree", allow_module_level=True)


def pages() -> list[Path]:
    """Return the pages that people wrote, without those that a build generates."""
    found = [path for suffix in ("md", "ipynb") for path in DOCS.rglob(f"*.{suffix}")]
    return [path for path in found if path.relative_to(DOCS).parts[0] not in (*GENERATED, "_site")]


def anchors(page: Path) -> set[str]:
    """Return the anchors of a Markdown page's headings, as forges generate them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", [*pages(), *ROOT.glob("*.md")], ids=lambda page: str(page.relative_to(ROOT)))
def test_links_between_files_lead_somewhere(page):
    for link in LINK.findall(page.read_text()):
        target = urlsplit(link)
        if target.scheme:
            continue
        path = (page.parent / target.path) if target.path else page
        assert path.exists(), f"{link} leads nowhere"
        if target.fragment and path.suffix == ".md":
            assert target.fragment in anchors(path), f"{link}: no such heading"


def test_each_page_has_one_place_in_the_contents():
    contents = re.findall(
        r"^```{toctree}\n(.*?)^```", (DOCS / "index.md").read_text(), re.MULTILINE | re.DOTALL
    )
    lines = [line for text in contents for line in text.splitlines() if line and not line.startswith(":")]
    named = [line for line in lines if line.partition("/")[0] not in GENERATED]
    own = [str(page.relative_to(DOCS).with_suffix("")) for page in pages()]
    assert sorted(named) == sorted(set(own) - {"index"})


def part_of_the_site(name: str) -> ModuleType:
    """Return a module of docs/_site."""
    pytest.importorskip("sphinx", reason="the site needs sphinx: pip install motes[docs]")
    if str(DOCS) not in sys.path:
        sys.path.append(str(DOCS))
    return importlib.import_module(f"_site.{name}")


@pytest.mark.parametrize(
    "docstring, markup",
    [
        ("v *= 1 - k, |v| grows", r"v \*= 1 - k, \|v\| grows"),
        ("look_ahead: s.", r"look_ahead: s\."),
        ("v_ is `World.render` or `a * b`", r"v\_ is :py:obj:`World.render` or ``a * b``"),
        ("`dt`: s. `space`:\nthe interval", "- ``dt``: s\\.\n- ``space``: the interval"),
        ("So:\n\n    a * b\n\nArgs:\n    a: *", "So::\n\n    a * b\n\nArgs:\n    a: \\*"),
        ("So::\n\n    a * `b`\n\na * b", "So::\n\n    a * `b`\n\na \\* b"),
    ],
)
def test_docstrings_become_markup(docstring, markup):
    assert "\n".join(part_of_the_site("docstrings").markup(docstring.split("\n"))) == markup


def test_links_lead_from_files_to_their_pages():
    files = part_of_the_site("files")
    text = "[a](../examples/snow.py) [b](ranks.md#space) [c](https://x.org) [d](../README.md#more) [e](#here)"
    told = "[a](files/examples/snow.py.md) [b](ranks.md#space) [c](https://x.org) [d](index.md) [e](#here)"
    assert files.relinked(text, DOCS, DOCS) == told
    moved = files.relinked("[a](docs/ranks.md#space) [b](examples)", ROOT, DOCS / "files")
    assert moved == "[a](../ranks.md#space) [b](examples/index.md)"


def test_declarations_are_told_with_their_comments():
    text = """// What the header is.
#pragma once

/// How far.
/// In metres.
inline int far(int a,
               int b) {
  return a + b;
}

/// Those that come.
class Crowd : public Base {
 public:
  /// Not this one.
  int size() const;
};

/// Told by its lines.
struct Last;
"""
    headers = part_of_the_site("headers")
    assert headers.opening(text) == "What the header is."
    assert headers.declarations(text) == [
        ("inline int far(int a, int b)", "How far. In metres."),
        ("class Crowd", "Those that come."),
        ("struct Last", "Told by its lines."),
    ]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site, with a loop video for one effect of the gallery; every warning is an error."""
    missing = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"the site needs {', '.join(missing)}: pip install motes[docs]")
    folder = tmp_path_factory.mktemp("site")
    (folder / "loops").mkdir()
    (folder / "loops" / f"{LOOP}.mp4").write_bytes(b"a film")
    (folder / "loops" / "no_longer_there.mp4").write_bytes(b"a film")
    job = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-d", str(folder / "doctrees")]
    job += ["-D", f"site_loops={folder / 'loops'}", str(DOCS), str(folder / "html")]
    done = subprocess.run(
        job, capture_output=True, text=True, timeout=600, env={**os.environ, "LC_ALL": "C.UTF-8"}
    )
    assert done.returncode == 0, done.stderr
    return folder / "html"


class Links(HTMLParser):
    """The link and media targets of a page of the site, and its anchors."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.targets: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src", "poster") and value:
                self.targets.append(value)
            if name == "id" and value:
                self.anchors.add(value)


@pytest.mark.slow
def test_no_link_of_the_site_is_broken(site):
    read = {path: Links(path) for path in sorted(site.rglob("*.html"))}
    assert len(read) > 100
    broken = []
    for page, links in read.items():
        for target in links.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            path = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            found = path.is_file() and (
                path not in read or not parts.fragment or unquote(parts.fragment) in read[path].anchors
            )
            if not found:
                broken.append(f"{page.relative_to(site)}: {target}")
    assert broken == []


def public_names() -> set[str]:
    """Return every public name of the package and of its public modules, with the methods of classes."""
    names = set()
    modules = {f"motes.{name}": getattr(motes, name) for name in motes.__all__}
    modules = {"motes": motes, **{name: thing for name, thing in modules.items() if inspect.ismodule(thing)}}
    for prefix, module in modules.items():
        names |= {f"{prefix}.{name}" for name in module.__all__}
    methods = {f"motes.{name}" for name in ("World", "System", "Frame", "Movie")}
    for full in methods:
        thing = getattr(motes, full.partition(".")[2])
        names |= {
            f"{full}.{name}" for name in dir(thing) if name[0] != "_" and callable(getattr(thing, name))
        }
    return names


@pytest.mark.slow
def test_every_public_name_has_an_entry(site):
    inventory = zlib.decompress((site / "objects.inv").read_bytes().split(b"\n", 4)[4]).decode()
    described = set(re.findall(r"^(\S+) py:", inventory, re.MULTILINE))
    assert sorted(public_names() - described) == []


@pytest.mark.slow
def test_a_class_is_shown_with_its_arguments(site):
    page = (site / "reference" / "python" / "motes.balance.html").read_text()
    shown = page.partition('id="motes.balance.Diffusive"')[2].partition("</dt>")[0]
    text = re.sub(r"<[^>]+>", "", shown)
    for name in inspect.signature(motes.balance.Diffusive).parameters:
        assert f"{name}:" in text


@pytest.mark.slow
def test_every_header_of_the_core_is_described(site):
    for header in sorted((ROOT / "cpp").rglob("*.h")):
        name = header.relative_to(ROOT / "cpp")
        page = (site / "reference" / "cpp" / f"{name.parent}.html").read_text()
        section = page.partition(f">{name}</span>")[2].partition("<h2")[0]
        assert "<p>" in section, f"{name} has nothing to say of itself"


@pytest.mark.slow
def test_the_gallery_moves_where_a_loop_has_been_made(site):
    page = (site / "gallery.html").read_text()
    assert re.findall(r'<video [^>]*src="([^"]*)"', page) == [f"loops/{LOOP}.mp4"]
    assert (site / "loops" / f"{LOOP}.mp4").read_bytes() == b"a film"
    assert len(list((site / "loops").iterdir())) == 1
    stills = len(list((DOCS / "gallery").rglob("*.png")))
    assert page.count("<img ") == stills - 1
