"""Run one of the example animations, which are installed with the package; without a name, list them.

  python -m motes demo
  python -m motes demo waterfall
  python -m motes demo -n 4 galaxy --size 1280x720 --particles 100000
  python -m motes demo galaxy --help

It writes out/NAME.mp4, and its middle frame as out/NAME.png. -n is the number of ranks; a single one also
uses all cores. --live shows the run in a browser. Other options after the name go to the script: --frames,
--seed, --out and more; --help after a name lists them.
"""

from __future__ import annotations

import argparse
import ast
from pathlib import Path

from .._io.output import tell
from .._launch import starting
from ..errors import MotesError, near
from .parser import Parser, add_json, positive, print_figures

__all__ = ["about", "configure", "names", "run", "script"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `demo`."""
    parser.usage = "python -m motes demo [-n N] [--live] [NAME [the script's options]]"
    _add_own(parser)
    parser.add_argument("name", nargs="?", metavar="NAME", help="the demo (without it: list all)")
    parser.add_argument(
        "options", nargs=argparse.REMAINDER, metavar="...", help="options of the demo's script"
    )


def run(args: argparse.Namespace) -> int:
    """Run the demo, or list all."""
    if args.name is None:
        sentences = {name: about(name) for name in names()}
        width = max(map(len, sentences), default=0)
        text = "\n".join(f"{name:<{width}}  {sentence}" for name, sentence in sentences.items())
        print_figures(args, sentences, text)
        return 0
    if args.name not in names():
        raise MotesError(f"no demo is called {args.name!r}{near(args.name, names()) or _all()}")
    own = Parser(prog="python -m motes demo", add_help=False)
    _add_own(own)
    own.set_defaults(**{name: getattr(args, name) for name in ("ranks", "live", "json")})
    args, options = own.parse_known_args(args.options, argparse.Namespace(name=args.name))
    program = [str(script(args.name)), *options]
    tell(f"motes demo: {about(args.name)}")
    return _run_live(args.ranks, program) if args.live else starting.run(args.ranks, program)


def names() -> list[str]:
    """Return the names of all demos."""
    return sorted(path.stem for path in _folder().rglob("*.py"))


def script(name: str) -> Path:
    """Return the path of a demo's script."""
    return next(_folder().rglob(f"{name}.py"))


def about(name: str) -> str:
    """Return a demo's description: the first line of its script's docstring."""
    lines = (ast.get_docstring(ast.parse(script(name).read_text(encoding="utf-8"))) or "").splitlines()
    return lines[0].split(": python -m motes")[0] if lines else ""


def _folder() -> Path:
    """Return the folder of the examples: beside the package's modules, or in the source tree."""
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "_examples", package.parents[1] / "examples"):
        if (folder / "snow.py").is_file():
            return folder
    raise MotesError("this installation of motes has no examples")


def _add_own(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-n", "--ranks", type=positive, default=1, metavar="N", help="number of ranks (1)")
    parser.add_argument("--live", action="store_true", help="show the run in a browser as it runs")
    add_json(parser)


def _run_live(ranks: int, program: list[str]) -> int:
    from . import COMMANDS, main

    if "live" not in COMMANDS:
        raise MotesError("--live: this version of motes cannot show a run as it runs")
    return main(["live", "-n", str(ranks), *program])


def _all() -> str:
    return "; `python -m motes demo` lists all"
