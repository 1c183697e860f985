"""Make the gallery: `make_gallery.py [--stills] [--loops] [--opening] [--page] [NAMES]`.

Writes a still of each effect, docs/gallery/NAME.png, and a loop of four seconds, out/loops/NAME.mp4 (H.264),
which is not committed. --opening writes the loop at the top of the README, docs/gallery/opening.webp. --page
writes docs/gallery.md and the README's wall from the scripts. Without an option, writes all.
"""

from __future__ import annotations

import argparse
import ast
import os
import subprocess
import sys
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

import motes

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
STILLS = ROOT / "docs" / "gallery"
LOOPS = ROOT / "out" / "loops"
PAGE = ROOT / "docs" / "gallery.md"
NO_EFFECTS = ("export", "heterogeneous")
OPENING = "autumn"
"""The effect at the top of the README. Animated WebP needs a tenth of an APNG's bytes."""

SIZE, LOOP_SIZE, FPS = (960, 540), (640, 360), 24
LOOP_FRAMES, BLENDED = 96, 24
MOST_BYTES, MOST_BYTES_OPENING = 250_000, 1_500_000
COLUMNS = 4
WARM = {"waterfall": 60, "swirl": 110, "volcano": 120, "hail": 24, "smoke": 110, "fountain": 0, "flame": 30}
"""Frames until an effect is in its steady state, if not `USUAL_WARM`."""
USUAL_WARM = 48
ONE_SHOT = ("explosion", "galaxy", "dam", "heap", "photo", "two_suns", "flag", "shielding", "bounce_toy")
ONE_SHOT += ("launch", "letters", "pour", "focus", "winter")
"""Effects that are shown from their start."""
STILL = {
    **{"explosion": 27, "two_suns": 100, "galaxy": 110, "dam": 44, "heap": 110, "portal": 60, "photo": 60},
    **{"flag": 40, "smoke": 90, "flamethrower": 48, "confetti": 80, "autumn": 100, "ribbons": 60},
    **{"launch": 84, "letters": 36, "waterfall": 72, "tornado": 72, "hail": 48, "winter": 110, "pour": 120},
    **{"focus": 44, "snow": 40, "fountain": 40},
}
"""The frame of the still, if not the middle of the loop."""

Pixels = NDArray[Any]


def effects() -> list[str]:
    """Return the names of all effects."""
    return sorted(path.stem for path in _scripts() if path.stem not in NO_EFFECTS)


def script(name: str) -> Path:
    """Return the script of an effect."""
    return next(path for path in _scripts() if path.stem == name)


def still(name: str) -> Path:
    """Return the path of an effect's still, which mirrors that of its script."""
    return (STILLS / script(name).relative_to(EXAMPLES)).with_suffix(".png")


def _scripts() -> list[Path]:
    return [*EXAMPLES.glob("*.py"), *EXAMPLES.glob("light/*.py")]


def sentence(name: str) -> str:
    """Return the description of the effect from its script's docstring."""
    head = ast.get_docstring(ast.parse(script(name).read_text())) or ""
    return head.split(": python -m motes")[0]


def shows(name: str) -> list[str]:
    """Return the recording methods that a script calls, the rarest among all effects first."""
    counts: dict[str, int] = {}
    for other in effects():
        for call in _calls(other):
            counts[call] = counts.get(call, 0) + 1
    return sorted(_calls(name), key=lambda call: (counts[call], call))


@cache
def _calls(name: str) -> set[str]:
    tree = ast.parse(script(name).read_text())
    called = {node.func.attr for node in ast.walk(tree) if _is_method_call(node)}
    own = {call for call in dir(motes.System) if not call.startswith("_")} - {"configure", "set", "move"}
    return called & own


def _is_method_call(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)


def pixels(path: Path) -> NDArray[np.uint8]:
    """Read a picture."""
    import av

    with av.open(str(path)) as picture:
        return next(picture.decode(video=0)).to_ndarray(format="rgb24")


def film(name: str, frames: int, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Run an effect and return its frames."""
    import av

    with TemporaryDirectory() as out:
        job = [sys.executable, str(script(name)), "--frames", str(frames), "--out", out]
        environment = {**os.environ, "MOTES_PROGRESS": "off"}
        subprocess.run([*job, "--size", f"{size[0]}x{size[1]}"], check=True, env=environment)
        with av.open(f"{out}/{name}.mp4") as movie:
            return np.stack([frame.to_ndarray(format="rgb24") for frame in movie.decode(video=0)])


def closed(shots: Pixels) -> Pixels:
    """Return all but the first second of frames, with the last second blended into that first one."""
    loop = shots[BLENDED:].astype(np.float32)
    part = ((np.arange(BLENDED) + 1) / (BLENDED + 1)).reshape(-1, *[1] * (shots.ndim - 1))
    loop[-BLENDED:] = (1 - part) * loop[-BLENDED:] + part * shots[:BLENDED]
    return loop


def write_loop(path: Path, frames: Pixels) -> None:
    """Encode a loop small enough for a page."""
    import av

    path.parent.mkdir(parents=True, exist_ok=True)
    for quality in range(30, 52, 3):
        with av.open(str(path), "w", options={"movflags": "faststart"}) as movie:
            stream = movie.add_stream("libx264", rate=Fraction(FPS))
            stream.width, stream.height = LOOP_SIZE
            stream.pix_fmt = "yuv420p"
            stream.options = {"crf": str(quality), "preset": "slow"}
            for shot in (np.clip(frames, 0, 255) + 0.5).astype(np.uint8):
                frame = av.VideoFrame.from_ndarray(shot, format="rgb24")
                movie.mux(stream.encode(frame.reformat(*LOOP_SIZE, format="yuv420p", interpolation="AREA")))
            movie.mux(stream.encode())
        if path.stat().st_size <= MOST_BYTES:
            return


def write_opening(frames: Pixels) -> None:
    """Write the loop at the top of the README as an animated WebP."""
    from PIL import Image

    shots = [Image.fromarray((np.clip(shot, 0, 255) + 0.5).astype(np.uint8)) for shot in frames]
    shots = [shot.resize(LOOP_SIZE, Image.Resampling.BOX) for shot in shots]
    path = STILLS / "opening.webp"
    for quality in range(75, 20, -5):
        how = {"duration": round(1000 / FPS), "loop": 0, "quality": quality, "method": 5}
        shots[0].save(path, save_all=True, append_images=shots[1:], **how)
        if path.stat().st_size <= MOST_BYTES_OPENING:
            return


def write_still(path: Path, picture: Pixels) -> None:
    """Save a picture at half its size, each pixel the mean light of four."""
    from PIL import Image

    shown = picture / 255
    light = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    half = light.reshape(SIZE[1] // 2, 2, SIZE[0] // 2, 2, 3).mean((1, 3))
    shown = np.where(half <= 0.0031308, 12.92 * half, 1.055 * half ** (1 / 2.4) - 0.055)
    Image.fromarray((shown * 255 + 0.5).astype(np.uint8)).save(path, optimize=True)


def make(name: str, *, stills: bool, loop: bool, opening: bool) -> None:
    """Render an effect once, and write its still, its loop and the README's loop as requested."""
    warm = 0 if name in ONE_SHOT else WARM.get(name, USUAL_WARM)
    shown = STILL.get(name, warm + BLENDED + LOOP_FRAMES // 2)
    shots = film(name, warm + BLENDED + LOOP_FRAMES if loop or opening else shown + 1, SIZE)
    if stills:
        write_still(still(name), shots[shown])
    if loop:
        write_loop(LOOPS / f"{name}.mp4", closed(shots[warm:]))
    if opening:
        write_opening(closed(shots[warm:]))


def page() -> str:
    """Return docs/gallery.md."""
    lines = [
        "# Gallery",
        "",
        "Written by `docs/scripts/make_gallery.py`. Each effect is one short script; pictures link to it.",
        "`python -m motes demo NAME` runs it and writes `out/NAME.mp4`; `--particles`, `--frames`,",
        "`--size 1920x1080` and `--seed` change it. Effects look the same at any resolution.",
        "`python docs/scripts/make_gallery.py --loops` makes four-second loops, out/loops/NAME.mp4;",
        "`--opening` makes the README's. [What is still missing](notes/gallery.md)",
        "compared with other tools.",
    ]
    for name in effects():
        methods = ", ".join(f"`{method}`" for method in shows(name)[:3])
        lines += [
            "",
            f"## {name}",
            "",
            f"[![{name}]({still(name).relative_to(PAGE.parent)})](../{script(name).relative_to(ROOT)})",
            "",
        ]
        lines += [f"{sentence(name)} ({methods})."]
    return "\n".join(lines) + "\n"


def wall() -> str:
    """Return the README's table of all stills."""
    names = effects()
    lines = ["|" + " |" * COLUMNS, "|" + "---|" * COLUMNS]
    for k in range(0, len(names), COLUMNS):
        row = names[k : k + COLUMNS]
        stills = [f"[![{name}]({still(name).relative_to(ROOT)})](docs/gallery.md#{name})" for name in row]
        scripts = [f"[{name}]({script(name).relative_to(ROOT)})" for name in row]
        for cells in (stills, scripts):
            lines.append("| " + " | ".join(cells + [""] * (COLUMNS - len(row))) + " |")
    return "\n".join(lines) + "\n"


def write_page() -> None:
    """Write the page, and the wall into the README."""
    PAGE.write_text(page())
    readme = ROOT / "README.md"
    before, head, rest = readme.read_text().partition("## Gallery\n")
    _, next_, after = rest.partition("\n## ")
    intro = rest.partition("\n|")[0]
    readme.write_text(f"{before}{head}{intro}\n{wall()}{next_}{after}")


def main() -> None:
    """Make the files that the options request."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for option in ("stills", "loops", "opening", "page"):
        parser.add_argument(f"--{option}", action="store_true")
    parser.add_argument("names", nargs="*", metavar="NAMES")
    args = parser.parse_args()
    everything = not (args.stills or args.loops or args.opening or args.page)
    stills, loops = everything or args.stills, everything or args.loops
    if stills or loops or args.opening:
        for name in args.names or (effects() if stills or loops else [OPENING]):
            opening = name == OPENING and (everything or args.opening)
            make(name, stills=stills, loop=loops, opening=opening)
            loop = LOOPS / f"{name}.mp4"
            print(name, f"{loop.stat().st_size / 1000:.0f} kB" if loop.exists() else "", flush=True)
    if everything or args.page:
        write_page()


if __name__ == "__main__":
    main()
