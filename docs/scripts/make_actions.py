"""Write the pages of actions from the docstrings of motes.actions: `python docs/scripts/make_actions.py`.

A test compares the files with `pages()`, so they are always up to date. costs.json has the costs of actions:
`MOTES_SIMD=avx2 python -m motes bench actions --json > docs/scripts/costs.json` measures them again.
"""

from __future__ import annotations

import inspect
import json
import re
import textwrap
from pathlib import Path
from types import ModuleType

from motes import actions
from motes._system.action_methods import ActionMethods
from motes._values.values import text_of
from motes.actions import between, forces, guides, laws, motion, targets

DOCS = Path(__file__).resolve().parents[1]
COSTS = json.loads(Path(__file__).with_name("costs.json").read_text())
ALONE = [
    ("Forces and torques", forces),
    ("Fields and paths", guides),
    ("Toward given values", targets),
    ("Collisions, deaths and movement", motion),
]
PAGES = {
    "actions_alone.md": ("Actions on single particles", "", ALONE),
    "actions_between.md": (
        "Actions between particles",
        "[Particles that meet](meetings.md) introduces them.",
        [("", between), ("Laws of your own", laws)],
    ),
}
WRITTEN = """
Written by `docs/scripts/make_actions.py` from the docstrings of `motes.actions`; change those.
"""
SYMBOLS = """
The first item of each action is its formula: x is a particle's position in m, v its velocity in m/s, dt the
length of the (sub)step in seconds, unit(y) is y / |y|. [Actions](actions.md) lists all.
"""
OPENING = """
An action acts on each particle [alone](actions_alone.md), or [between particles](actions_between.md). Every
action also takes `where=`: a shape or a comparison of columns. `s.gravity(...)` records
`motes.actions.Gravity(...)`. Names in the table link to formulas and parameters.

Unless another source is named, an action comes from D. McAllister's Particle System API, and agrees with
results of his library (`tests/actions/test_conformance.py`), with two exceptions: his `sink` of
a `Plane` kills above it, and his `bounce` is ours with `exact_hit=False`.

Most cost less than a nanosecond per particle and step ([the costs](notes/costs_of_actions.md)); `curl_noise`,
`field` and `follow_path` cost about ten, `sort` 75.
"""

COST = """
What each action costs. "ns" is what it adds to a particle's step: nanoseconds on one core of {machine} with
{simd}. The paper's fountain is timed with and without the action; the figure is the difference, the median of
repeats over {particles} particles (`python -m motes bench actions`). "in cache" is the same for 512
particles, whose columns stay in the first-level cache, so it is only arithmetic. Differences of 0.2 ns are
noise. What actions between particles cost depends on how many are within reach: [heaps.md](../lab/heaps.md)
has figures for `collide`.
"""
SHORT = 240
"""Parameters share a line if their texts have fewer characters in total."""
OWN_NAME = re.compile(r"McAllister's \w+\.")
"""The usual source, which only the overview names."""
# Why an action adds more than 1 ns.
REASONS = {
    "random_acceleration random_velocity random_displacement random_rotational_velocity": "random numbers "
    "that depend only on seed, particle and step: ten integer multiplications per four words",
    "jet": "random numbers for each vector of particles with at least one inside",
    "explosion": "an exponential, a square root and a division",
    "vortex": "a logarithm and an exponential, a square root and divisions",
    "avoid": "the point where the path meets the shape: a square root and divisions, more for those that do",
    "field": "eight nodes around each particle, three numbers each, from anywhere in the table",
    "follow_path": "each of the path's segments (here 16) is visited twice",
    "curl_noise": "eight corners of a lattice cell, three gradients each",
    "orbit_point orbit_line": "a square root and a division for each particle",
    "color_over_life size_over_life alpha_over_life": "a division, and two table entries per component",
    "set": "depends on the expression: here two instructions",
    "target_color target_size": "up to four columns that other actions do not touch",
    "restore copy_vertex_b": "up to 18 columns that other actions do not touch, and almost no arithmetic",
    "sort": "does not act on blocks: all particles are sorted after the list has run, with four passes over "
    "the keys, then one per column, which writes all over memory",
}


def words(name: str) -> str:
    """Return the method's name for a class's name."""
    return re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower()


def wrapped(text: str, indent: str = "") -> str:
    """Fill lines of 120 characters."""
    return textwrap.fill(
        " ".join(text.split()), 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def signature(name: str) -> str:
    """Return the method's signature, without self and where."""
    parameters = list(inspect.signature(getattr(ActionMethods, name)).parameters.values())[1:]
    shown = []
    for p in parameters:
        if p.name == "where":
            continue
        prefix = "**" if p.kind is p.VAR_KEYWORD else ""
        default = "" if p.default is p.empty else f"={p.default}"
        shown.append(f"{prefix}{p.name}{default}")
    return f"{name}({', '.join(shown)})"


def parts(docstring: str) -> tuple[list[str], str, list[tuple[str, str]], str]:
    """Split a docstring into description, formula, parameters and source."""
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


def anchor(name: str) -> str:
    """Return the anchor of an action's heading, as forges name it."""
    return re.sub(r"[^\w\- ]", "", signature(name).lower()).replace(" ", "-")


def section(name: str, kind: type, heading: str) -> str:
    """Describe one action."""
    what, formula, parameters, source = parts(text_of(kind))
    lines = [f"{heading} `{signature(name)}`", ""]
    for paragraph in what:
        lines += [wrapped(paragraph), ""]
    lines += [wrapped(f"- {formula}", "  ")]
    listed = [f"`{parameter}`: {text}" for parameter, text in parameters]
    together = " ".join(listed)
    listed = [together] if len(together) < SHORT else listed
    lines += [wrapped(f"- {one}", "  ") for one in listed if one]
    if not OWN_NAME.fullmatch(source):
        lines += [wrapped(f"- source: {source}", "  ")]
    lines += [""]
    return "\n".join(lines)


def cost(name: str, which: str) -> str:
    """Return a measured cost in nanoseconds; empty for actions between particles."""
    if name not in COSTS["actions"]:
        assert actions_between(name), f"{name} has not been measured: python -m motes bench actions"
        return ""
    ns = COSTS["actions"][name][which]
    return "< 0.1" if ns < 0.1 else f"{ns:.1f}" if ns < 20 else f"{ns:.0f}"


def actions_between(name: str) -> bool:
    """Return whether an action acts between particles."""
    return name in [words(kind) for kind in [*between.__all__, *laws.__all__]]


def costly() -> str:
    """List the actions that add more than a nanosecond, with reasons.

    Raises KeyError if a reason is missing.
    """
    reasons = {name: (names, why) for names, why in REASONS.items() for name in names.split()}
    costs = COSTS["actions"]
    computing = [name for name in costs if costs[name]["added_in_cache_ns"] > 1]
    waiting = [name for name in costs if costs[name]["added_ns"] > 1 and name not in computing]
    lines = []
    for title, chosen in (
        ("More than 1 ns of arithmetic, and why:", computing),
        ("More than 1 ns with columns from memory, less in the first-level cache:", waiting),
    ):
        lines += ["", title, ""]
        for names, why in dict.fromkeys(reasons[name] for name in chosen):
            known = ", ".join(f"`{n}`" for n in names.split() if n in chosen)
            lines.append(wrapped(f"- {known}: {why}.", "  "))
    return "\n".join(lines[1:])


def kinds(module: ModuleType) -> dict[str, type]:
    """Return the actions defined in a module, by the names of their methods."""
    own = [k for k in vars(module).values() if inspect.isclass(k) and k.__module__ == module.__name__]
    return {words(kind.__name__): kind for kind in own if issubclass(kind, actions.Action)}


def overview() -> str:
    """Return the page that lists all actions."""
    rows = ["| action | what it does to a particle |", "|---|---|"]
    for page, (_, _, families) in PAGES.items():
        for name, kind in (pair for _, module in families for pair in kinds(module).items()):
            what = " ".join(parts(text_of(kind))[0][0].split())
            rows.append(f"| [`{name}`]({page}#{anchor(name)}) | {what} |")
    opening = [wrapped(p) for p in [WRITTEN, *OPENING.strip().split("\n\n")]]
    return "\n\n".join(["# Actions", *opening, "\n".join(rows)]) + "\n"


def costs() -> str:
    """Return the page of what actions cost."""
    rows = ["| action | ns | in cache |", "|---|---|---|"]
    for name in COSTS["actions"]:
        rows.append(f"| `{name}` | {cost(name, 'added_ns')} | {cost(name, 'added_in_cache_ns')} |")
    measured = COST.format(**{**COSTS, "particles": f"{COSTS['particles'] / 1e6:g} million"})
    opening = [
        wrapped(
            WRITTEN.replace("the docstrings of `motes.actions`; change those", "docs/scripts/costs.json")
        ),
        wrapped(measured),
    ]
    return "\n\n".join(["# The costs of actions", *opening, "\n".join(rows), costly().strip()]) + "\n"


def described(title: str, more: str, families: list[tuple[str, ModuleType]]) -> str:
    """Return a page that describes families of actions; a family without a name gets no heading."""
    lines = [f"# {title}", "", wrapped(WRITTEN), "", wrapped(SYMBOLS + more), ""]
    for family, module in families:
        lines += [f"## {family}", ""] if family else []
        heading = "###" if family else "##"
        lines += [section(name, kind, heading) for name, kind in kinds(module).items()]
    return "\n".join(lines).rstrip() + "\n"


def pages() -> dict[Path, str]:
    """Return all pages."""
    made = {DOCS / name: described(*what) for name, what in PAGES.items()}
    return {DOCS / "actions.md": overview(), DOCS / "notes" / "costs_of_actions.md": costs(), **made}


if __name__ == "__main__":
    for path, text in pages().items():
        path.write_text(text)
