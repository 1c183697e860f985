"""Random pictures drawn by hypothesis: systems of every kind, size and blend in one scene."""

from __future__ import annotations

from hypothesis import strategies as st
from random_lists import FRAMES
from random_shapes import numbers, triples

__all__ = ["HEADER", "picture_script"]

Text = st.SearchStrategy[str]
KINDS = ("point", "disc", "sphere", "image", "mesh", "ribbon")
FACINGS = ("camera", "velocity", "orientation")
BLENDS = ("add", "alpha", "opaque")
PATHS = ("auto", "gather", "tiles", "composite")
SOLIDS = (
    "Plane((0, -1, 0), (0, 1, 0))",
    "Sphere((0.5, 0, 0), 0.8)",
    "motes.Solid(Box((-1, -1, -1), (0, 0.5, 0.25)), (0.9, 0.4, 0.2), light=0.5)",
    "motes.Solid(Box((-1, -2, -1), (1, -1, 1)), image=LEAF[:, :, :3], scale=0.7)",
    "motes.Mesh([(-1, -1, 0), (1, -1, 0.5), (0, 1, 0)], [(0, 1, 2)])",
    "motes.Solid(WEDGE.at((0.2, 0.1, 0), angle_deg=30, moving_from=WEDGE), image=LEAF[:, :, :3])",
    "motes.Solid(Sphere((-0.6, 0.2, 1), 0.5), 'gold', roughness=0.3, metal=1)",
    "motes.Solid(SMOOTH, roughness=0.1, image=LEAF[:, :, :3])",
    "motes.Solid(BRASS.at((-0.3, 0.2, 0.4), axis=(1, 1, 0), angle_deg=50))",
    "motes.Solid(Sphere((0.4, 0.3, 1.5), 0.7), glass=1.5)",
    "motes.Solid(SMOOTH.at((-0.4, 0.2, 1)), 'lightgreen', glass=1.33)",
    "motes.Solid(Cylinder((0, -1, 1), (0, 1, 1), 0.5, 0.4), glass=1.5)",
    "motes.Solid(Plane((0, -0.5, 0), (0, 1, 0)), glass=1.33)",
)
SKIES = ("motes.Gradient('#89a', 'navy')", "motes.Gradient('orange', 'teal', 'black')", "LEAF[:, :, :3]")
IMAGES = (
    "LEAF",
    "LEAF",
    "[LEAF, LEAF[::-1], LEAF[:, ::-1]]",
    "LEAF, tiles=(1, 3)",
    "[LEAF, LEAF[::-1]], tiles=(7, 1)",
)
MESHES = ("WEDGE", "FLAP", "SMOOTH", "BRASS", "SMOOTH, image=LEAF[:, :, :3]")
PICKS = ("'random'", "'age'", "ex.column('position')[0] * 3 + ex.time()", "1.625")
COLORS = ("Uniform((0, 0, 0), (1, 1, 1))", "Uniform((0, 0, 0), (9, 2, 1))", "(1, 0.5, 0.25)", "(9, 1.6, 0.2)")
HEADER = """\
import hashlib
import numpy as np
import motes
from motes import Normal, Uniform
from motes import expressions as ex
from motes.shapes import *

LEAF = (np.arange(9 * 7 * 4).reshape(9, 7, 4) * 37 % 256).astype(np.uint8)

CORNERS = np.array([(-1, -1, -1), (1, -1, -0.5), (0, 1, -1), (0, 0, 1.5)], np.float32)
WEDGE = motes.Mesh(CORNERS, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
FLAP = motes.Mesh(CORNERS, [(0, 1, 2), (1, 3, 2)])
PLACED = {"uv": CORNERS[:, :2], "smooth": True}
SMOOTH = motes.Mesh(CORNERS, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)], **PLACED)
METAL = Material((0.9, 0.7, 0.4), 0.5, 1, LEAF[:, :, :3], LEAF[::-1, :, 1:])
BRASS = motes.Mesh(CORNERS, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)], material=METAL, **PLACED)

def shown(picture):
    if not picture:
        return ""
    planes = [picture.layer(name) for name in world.renderer.layers]
    planes += [picture.linear] if world.renderer.linear else []
    return " ".join(hashlib.sha256(plane.tobytes()).hexdigest() for plane in planes)
"""


@st.composite
def sprite(draw: st.DrawFn) -> str:
    """Draw a sprite of any kind."""
    kind = draw(st.sampled_from(KINDS))
    if kind == "surface":
        foam = draw(st.just(0) | numbers(0.1, 10))
        shadow = draw(st.just(0) | numbers(0, 1))
        radius, glass = draw(numbers(0.01, 1)), draw(numbers(1, 2))
        return f"motes.Sprite('surface', radius={radius}, foam={foam}, glass={glass}, shadow={shadow})"
    facts = [f"{kind!r}", f"blend={draw(st.sampled_from(BLENDS))!r}"]
    width = draw(st.sampled_from(["", "pixels=None", "pixels=#", "pixels=#", "height=0.#"]))
    if width and kind not in ("mesh", "ribbon"):
        facts.append(width.replace("#", str(draw(st.integers(1, 40)))))
    if kind == "image":
        facts.append(f"image={draw(st.sampled_from(IMAGES))}")
        if facts[-1] != "image=LEAF":
            facts.append(f"pick={draw(st.sampled_from(PICKS))}")
    if kind == "mesh":
        facts.append(f"mesh={draw(st.sampled_from(MESHES))}")
    if kind == "ribbon":
        facts.append(f"width={draw(numbers(0.01, 1))}, length={draw(numbers(0.01, 3))}")
    facing = draw(st.sampled_from(FACINGS)) if kind in ("image", "mesh") else "camera"
    if facing != "camera":
        facts.append(f"facing={facing!r}")
    if draw(st.booleans()):
        facts.append(f"softness={draw(numbers(0, 1))}")
    lit = draw(st.booleans())
    if lit:
        facts.append("lit=True")
    card = lit and kind == "image" and facing != "camera"
    if (card or kind in ("sphere", "mesh")) and draw(st.booleans()):
        facts.append(f"roughness={draw(numbers(0, 1))}, metal={draw(st.sampled_from([0, 0.5, 1]))}")
    if kind != "ribbon" and draw(st.booleans()):
        facts.append(f"shadow={draw(numbers(0, 1))}")
    return f"motes.Sprite({', '.join(facts)})"


@st.composite
def renderer(draw: st.DrawFn) -> list[str]:
    """Draw the lines that make a renderer."""
    width, height = draw(st.integers(1, 200)), draw(st.integers(1, 150))
    if draw(st.integers(0, 7)) == 0:  # bloom averages pixels from 500 pixels on
        width, height = min(width, 24), 640
    facts = [f"path={draw(st.sampled_from(PATHS))!r}", f"exposure={draw(numbers(0.25, 2))}"]
    optional = {
        "shutter": (numbers(0.05, 1) | numbers(1, 4)).map(str),
        "bloom": numbers(0.05, 0.5).map(str),
        "smooth": st.just("False"),
        "linear": st.just("True"),
        "layers": st.just("('depth', 'alpha', 'velocity')"),
        "background": st.one_of(triples(0, 1).map(str), st.sampled_from(SKIES)),
        "fog": numbers(1, 20).map(lambda metres: f"('silver', {metres})"),
        "objects": st.lists(st.sampled_from(SOLIDS), min_size=1, unique=True).map(
            lambda s: f"[{', '.join(s)}]"
        ),
        "lights": triples(-3, 3).map(lambda p: f"[motes.Light({p}, (1, 0.6, 0.2), 2)]")
        | triples(-3, 3).map(lambda p: f"[motes.Light({p}, 'orange', 2, radius=0.5)]")
        | triples(-3, 3).map(lambda p: f"[motes.Light({p}, 'teal', 90, spot=(({-p[0]}, 1, {-p[2]}), 70))]"),
        "sun_color": st.just("'orange'"),
        "occlusion": numbers(0.1, 1).map(str),
        "sun_power": st.sampled_from(["0", "0.5", "40"]),
        "sun_size": numbers(0.5, 40).map(str),
    }
    facts += [f"{name}={draw(value)}" for name, value in optional.items() if draw(st.booleans())]
    camera = "motes.Camera((0, 0.5, 6), (0, 0, 0))"
    return [f"world.renderer = motes.Renderer({width}, {height}, camera={camera}, {', '.join(facts)})"]


@st.composite
def picture_script(draw: st.DrawFn) -> str:
    """Draw a script of three systems that move, seen by a camera that moves."""
    facts = f"seed={draw(st.integers(0, 1000))}, roles={draw(st.sampled_from(['auto', 'shared']))!r}"
    lines = [f"world = motes.World({facts}, progress='off')", *draw(renderer())]
    for name in "abc":
        lines.append(
            f"{name} = world.system({name!r}, axis={draw(st.sampled_from('xyz'))!r}, sprite={draw(sprite())})"
        )
    lines += ["with world:", f"    for frame in world.frames({FRAMES}):"]
    body = [f"world.renderer.camera = motes.Camera(({draw(numbers(-1, 1))} * frame, 0.5, 6), (0, 0, 0))"]
    for name in "abc":
        size = draw(st.sampled_from(["Uniform((0, 0, 0), (0.5, 0, 0))", "(0.02, 0, 0)", "(2, 1, 1)"]))
        states = {
            "velocity": "Normal((0, 0, 0), (9, 9, 9))",
            "up": "Normal((0, 1, 0), (1, 1, 1))",
            "rotational_velocity": "Normal((0, 0, 0), (3, 3, 3))",
            "orientation": draw(st.sampled_from(["'random'", "(0, 0, 0, 1)"])),
            "spin": "Normal((0, 0, 0), (9, 9, 9))",
            "size": size,
            "color": draw(st.sampled_from(COLORS)),
            "lifetime": draw(st.sampled_from(["1e9", "0.2"])),
            "alpha": draw(st.sampled_from(["Uniform(0, 1)", "0.1", "1"])),
        }
        body.append(f"{name}.configure({', '.join(f'{key}={value}' for key, value in states.items())})")
        body.append(f"{name}.burst(Sphere((0, 0, 0), 2), count={draw(st.sampled_from([1, 8, 60]))})")
        if draw(st.integers(0, 7)) == 0:  # the sum of light is limited to some 4000
            body.append(f"{name}.burst((0.1, 0.2, 0), count=3000)")
        body.append(f"{name}.move()")
    if draw(st.booleans()):
        lens = f"focus={draw(numbers(1, 8))}, aperture={draw(numbers(0.01, 0.3))}"
        body.append(f"world.renderer.camera = motes.Camera((0, 0.5, 6), (0, 0, 0), {lens})")
    body += ["picture = world.render()", "note(f'{world.digest()} {shown(picture)}', picture)"]
    return "\n".join(lines + [f"        {line}" for line in body]) + "\n"
