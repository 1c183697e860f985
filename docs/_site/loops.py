"""Show loops instead of stills in the gallery; `python docs/scripts/make_gallery.py --loops` makes them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from sphinx.application import Sphinx

from _site.pages import ROOT

STILL = re.compile(r"^\[!\[(\w+)\]\((gallery/[\w/]+\.png)\)\]\([^)]*\)$", re.MULTILINE)
PAGE = "gallery"


def loops(app: Sphinx) -> dict[str, Path]:
    """Return the loops of the gallery's effects by name; ignore those of effects that no longer exist."""
    made = sorted((ROOT / app.config.site_loops).glob("*.mp4"))
    return {path.stem: path for path in made if still_of(app, path.stem)}


def still_of(app: Sphinx, name: str) -> Path | None:
    """Return the path of an effect's still, or None."""
    return next((Path(app.srcdir) / "gallery").rglob(f"{name}.png"), None)


def moving(app: Sphinx, docname: str, source: list[str]) -> None:
    """Replace stills with loops."""
    if docname != PAGE:
        return
    made = loops(app)

    def one(still: re.Match[str]) -> str:
        if still[1] not in made:
            return still[0]
        attributes = "autoplay muted loop playsinline"
        return f'<video {attributes} poster="{still[2]}" src="loops/{still[1]}.mp4"></video>'

    source[0] = STILL.sub(one, source[0])


def outdated(app: Sphinx, env: object, added: object, changed: object, removed: object) -> list[str]:
    """Reread the gallery in each build, because loops come and go."""
    return [PAGE]


def copy(app: Sphinx, exception: Exception | None) -> None:
    """Copy loops, and the stills that are shown until they play."""
    if exception is not None or app.builder.format != "html":
        return
    for name, path in loops(app).items():
        copies = {path: Path(app.outdir) / "loops" / path.name}
        if still := still_of(app, name):
            copies[still] = Path(app.outdir) / still.relative_to(app.srcdir)
        for file, place in copies.items():
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, place)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the handlers."""
    app.add_config_value("site_loops", "out/loops", "html", types=[str])
    app.connect("source-read", moving, priority=400)  # before links are turned
    app.connect("env-get-outdated", outdated)
    app.connect("build-finished", copy)
    return {"parallel_read_safe": True}
