"""Make what is quickly read: `make_recipes.py [NAMES]` runs recipes, or all and writes their pages.

A recipe is a short script, docs/recipes/NAME.py, with its picture, NAME.png. docs/recipes.md shows them,
docs/surface.md has every public name on one page, and llms.txt leads programs that read to both. A test makes
all of them again and compares.
"""

from __future__ import annotations

import ast
import inspect
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import motes

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
FOLDER = DOCS / "recipes"
GROUPS = {
    "Births": ("particles_from_an_array", "text_that_bursts", "moving_emitter", "children"),
    "What acts": (
        "a_law_of_your_own",
        "forces_between_particles",
        "flock_round_a_mesh",
        "a_heap_of_grains",
        "cloth",
    ),
    "What hits": ("leaves_that_come_to_rest", "snow_that_stays", "splashes"),
    "How it looks": ("opaque_or_alpha", "fire", "lit_smoke", "smooth_trail", "colour_by_speed"),
    "Camera": ("rack_of_focus", "motion_blur"),
    "Numbers": ("numbers_from_particles",),
}
"""The recipes in the order of the page, by subject."""

LLMS = """# motes

> Particle-system animations on clusters, as short Python scripts: a C++ core with Python on top. The same
> script and seed give the same particles and pixels on any number of MPI ranks, threads and processors.

A script records what happens in a frame; every rank runs the whole script and needs no `if rank == 0`. Units
are metres and seconds, y is up, colours are linear RGB or CSS names. Each frame ends with `world.render()` (a
picture) or `world.step()`. Run it by `python script.py`, or on four ranks by
`python -m motes run -n 4 script.py`.
"""


def recipes() -> list[str]:
    """Return the names of all recipes."""
    return [name for names in GROUPS.values() for name in names]


def script(name: str) -> Path:
    """Return the script of a recipe."""
    return FOLDER / f"{name}.py"


def run(name: str) -> bytes:
    """Run a recipe as a user would, and return the picture that it saves."""
    with TemporaryDirectory() as folder:
        environment = {**os.environ, "MOTES_PROGRESS": "off"}
        subprocess.run(
            [sys.executable, str(script(name))], check=True, cwd=folder, env=environment, timeout=300
        )
        return Path(folder, "out", f"{name}.png").read_bytes()


def told(name: str) -> tuple[str, str]:
    """Return a recipe's title and its explanation, from the first line of its script."""
    title, _, said = (ast.get_docstring(ast.parse(script(name).read_text())) or "").partition(": ")
    return title, said[:1].upper() + said[1:]


def code(name: str) -> str:
    """Return a recipe without its docstring."""
    return script(name).read_text().partition('"""\n\n')[2]


def page() -> str:
    """Return docs/recipes.md."""
    lines = [
        "# Recipes",
        "",
        "Written by `docs/scripts/make_recipes.py`. Each is a whole script: copy it, and change it.",
    ]
    for group, names in GROUPS.items():
        lines += ["", f"## {group}"]
        for name in names:
            title, said = told(name)
            lines += ["", f"### {title}", "", said, "", f"![{title}](recipes/{name}.png)", ""]
            lines += ["```python", code(name).rstrip(), "```"]
    return "\n".join(lines) + "\n"


def modules() -> dict[str, ModuleType]:
    """Return the public modules by name, the package itself first."""
    inner = {f"motes.{name}": getattr(motes, name) for name in motes.__all__}
    return {"motes": motes, **{name: module for name, module in inner.items() if inspect.ismodule(module)}}


def signature(thing: Any) -> str:
    """Return the arguments of something that is called, without quotes around types, or ""."""
    try:
        return str(inspect.signature(thing)).replace("'", "").removesuffix(" -> None")
    except (TypeError, ValueError):
        return ""


def first(thing: Any) -> str:
    """Return the first paragraph of a docstring, as one line."""
    return " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split())


def members(kind: type) -> Iterator[str]:
    """Yield a line for each public method and property that a class has itself or from a private base."""
    for name in sorted(name for name in dir(kind) if not name.startswith("_")):
        member = inspect.getattr_static(kind, name)
        bases = [base for base in kind.__mro__ if name in vars(base)]
        if not bases[0].__module__.startswith("motes") or (
            bases[0] is not kind and bases[0].__name__ in motes.__all__
        ):
            continue
        if isinstance(member, property):
            yield f"- `.{name}`: {first(member)}"
        elif inspect.isroutine(getattr(kind, name)):
            shown = signature(getattr(kind, name)).replace("(self, ", "(").replace("(self)", "()")
            yield f"- `.{name}{shown}`: {first(member)}"


def fields(thing: Any) -> Iterator[str]:
    """Yield a line for each field that a docstring describes."""
    block = re.search(
        r"^(?:Fields|Attributes|Args):\n((?:    .*\n?)+)", inspect.getdoc(thing) or "", re.MULTILINE
    )
    for name, text in re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", block[1] if block else "", re.MULTILINE):
        yield f"- `{name}`: {' '.join(text.split())}"


def entry(name: str, thing: Any) -> list[str]:
    """Return the lines about a public name: how it is called, what it is, its fields and methods."""
    if not (inspect.isclass(thing) or inspect.isroutine(thing)):
        return [f"### `{name}`", ""]
    lines = [f"### `{name}{signature(thing)}`", "", first(thing)]
    lines += ["", *fields(thing)] if any(fields(thing)) else []
    if inspect.isclass(thing) and any(members(thing)):
        lines += ["", *members(thing)]
    return [*lines, ""]


def surface() -> str:
    """Return docs/surface.md."""
    lines = [
        "# The whole surface",
        "",
        "Written by `docs/scripts/make_recipes.py`: every public name, from its docstring.",
        "",
    ]
    for full, module in modules().items():
        names = [name for name in module.__all__ if not inspect.ismodule(getattr(module, name))]
        lines += [f"## {full}", "", first(module), ""]
        for name in names:
            lines += entry(name, getattr(module, name))
    return "\n".join(lines).rstrip() + "\n"


def llms() -> str:
    """Return llms.txt: what motes is, and where more about it stands."""
    lines = [LLMS.rstrip(), "", "## Docs", ""]
    pages = {
        "surface": "every public name on one page",
        "recipes": "twenty scripts of ten lines with pictures",
    }
    pages |= {
        "guide": "the first script, then each part",
        "install": "requirements",
        "pictures": "sprites, light, camera",
    }
    pages |= {
        "actions": "all actions",
        "meetings": "forces between particles",
        "clusters": "many hosts, Slurm",
    }
    pages |= {"analysis": "reading the logs of runs", "checkpoints": "continuing a run"}
    return (
        "\n".join([*lines, *(f"- [{name}](docs/{name}.md): {said}" for name, said in pages.items())]) + "\n"
    )


def texts() -> dict[Path, str]:
    """Return what the script writes besides pictures, by path."""
    return {DOCS / "recipes.md": page(), DOCS / "surface.md": surface(), ROOT / "llms.txt": llms()}


def main() -> None:
    """Make the pictures of these recipes, or everything."""
    for name in sys.argv[1:] or recipes():
        (FOLDER / f"{name}.png").write_bytes(run(name))
    if not sys.argv[1:]:
        for path, text in texts().items():
            path.write_text(text)


if __name__ == "__main__":
    main()
