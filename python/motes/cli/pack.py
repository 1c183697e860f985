"""Join the files that the ranks of a run have exported into one file per frame, sorted by id.

  python -m motes pack out/snow -o out/snow-joined            .npz files, one per frame and system
  python -m motes pack out/snow -o out/snow.usd               for Blender and Houdini; needs the extra [usd]
  python -m motes pack out/snow.usd -o out/snow.pvd           for ParaView
  python -m motes pack out/pile --frame -1 -o pile.npz        one frame, to emit from in another script

The export may have any format: a directory, a .usd or a .pvd file. The joined files are the same for any
number of ranks.
"""

from __future__ import annotations

import argparse

from .parser import add_json, print_figures

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `pack`."""
    parser.add_argument("export", metavar="DIR", help="what motes.Export has written")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        required=True,
        help="a name ending in .usd or .pvd, a directory for .npz files, or one .npz file",
    )
    parser.add_argument("--system", metavar="NAME", help="only this system")
    parser.add_argument("--frame", type=int, metavar="K", help="only this frame; -1 is the last one")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Join the files and print how many there are."""
    from .._interchange.pack import pack

    result = pack(args.export, args.output, system=args.system, frame=args.frame)
    figures = {"output": args.output, **result}
    print_figures(
        args, figures, "{output}: {frames} frames, {particles} particles in {files} files".format(**figures)
    )
    return 0
