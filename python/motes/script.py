"""Helpers for scripts that are run by hand: parse command-line options, and end frames accordingly."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from ._values.options import Parser
from .balance import Balancer, by_name
from .errors import ArgumentError

if TYPE_CHECKING:
    from ._film.movie import Movie
    from ._picture.frame import Frame
    from ._world.world import World

__all__ = ["end_frame", "options", "print_digest"]

BALANCERS = "static, pairwise (the paper's), diffusive or prefix"


def options(
    description: str | None,
    *,
    space: str = "infinite",
    systems: int = 8,
    particles: int = 400_000,
    frames: int = 96,
    size: str = "1280x720",
    balancer: Literal["static", "pairwise", "diffusive", "prefix"] = "static",
    argv: Sequence[str] | None = None,
    **own: str | int | float,
) -> argparse.Namespace:
    """Parse a script's command line; the arguments set its defaults.

    There are also `--seed`, `--out` and `--log` (directories), `--digest`, `--no-images`, and `--axis` x, xz,
    ..., hilbert, morton or none.

    Args:
        description: the text of `--help`, usually the script's `__doc__`.
        space: the default of `--space`: LO,HI in metres, infinite or fit.
        systems: the default of `--systems`.
        particles: the default of `--particles`, the particles of each system.
        frames: the default of `--frames`.
        size: the default of `--size`, WxH in pixels.
        balancer: the default of `--balancer`: static, pairwise, diffusive or prefix.
        argv: the command line; None: that of the process.
        **own: the script's own options with their defaults: `wind=2.5` adds `--wind`, a float.

    Returns:
        The options as attributes: `size`, `axis`, `space` and `balancer` as Renderer and World take them,
        `images` is the opposite of `--no-images`, and `world` holds all arguments for World:
        `World(**args.world, renderer=...)`.
    """
    parser = Parser(description=description)
    parser.add_argument("--systems", type=_count, default=systems)
    parser.add_argument("--particles", type=_count, default=particles, help="of each system")
    parser.add_argument("--frames", type=_count, default=frames)
    parser.add_argument(
        "--size", type=_size, default=_size(size), metavar="WxH", help="of a frame, in pixels"
    )
    parser.add_argument(
        "--axis", type=_axis, default="x", help="how domains divide space: x, xz, ..., hilbert; none: by id"
    )
    parser.add_argument("--space", type=_space, default=_space(space), help="LO,HI (metres), infinite or fit")
    parser.add_argument(
        "--balancer", type=_balancer, default=_balancer(balancer), metavar="NAME", help=BALANCERS
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default="out", metavar="DIR", help="where pictures and movies go")
    parser.add_argument("--log", default=None, metavar="DIR", help="write the run's log there")
    parser.add_argument("--digest", action="store_true", help="print fingerprints of particles and pictures")
    parser.add_argument("--no-images", action="store_false", dest="images")
    for name, default in own.items():
        help_ = f"{type(default).__name__}, default {default!r}"
        parser.add_argument("--" + name.replace("_", "-"), type=type(default), default=default, help=help_)
    args = parser.parse_args(_joined(sys.argv[1:] if argv is None else argv))
    args.world = {name: getattr(args, name) for name in ("seed", "axis", "space", "balancer", "log")}
    return args


def __dir__() -> list[str]:
    return [*__all__]


def end_frame(world: World, movie: Movie, args: argparse.Namespace) -> None:
    """End the frame as `options` say: render or step, write the movie, print digests. Collective.

    Args:
        world: the world whose frame ends.
        movie: the movie to write to; its middle picture is also saved as a PNG beside it.
        args: the result of `options`.
    """
    picture = world.render() if args.images else world.step()
    movie.write(picture)
    if picture.index == args.frames // 2:
        picture.save(movie.path.with_suffix(".png"))
    if args.digest:
        print_digest(world, picture)


def print_digest(world: World, picture: Frame) -> None:
    """Print `frame particles_digest image_sha256` of the frame that has just ended. Collective.

    Args:
        world: the world whose frame has ended.
        picture: the frame that `render` or `step` returned; without a picture its hash is printed as "-".
    """
    particles = world.digest()
    if picture:
        print(picture.index, particles, picture.digest(), flush=True)
    elif not picture.made:
        world.say(f"{picture.index} {particles} -")


def _joined(argv: Sequence[str]) -> list[str]:
    """Rewrite `--space -30,30` as `--space=-30,30`: argparse would mistake the value for an option."""
    joined: list[str] = []
    for argument in argv:
        if joined and joined[-1] == "--space" and argument[:1] == "-" and argument[1:2].isdigit():
            joined[-1] += "=" + argument
        else:
            joined.append(argument)
    return joined


def _count(text: str) -> int:
    if not re.fullmatch(r"\d{1,18}", text):
        raise argparse.ArgumentTypeError(f"must be a whole number, 0 or more, got {text!r}")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text)
    if match is None or "0" in (match[1].lstrip("0") or "0", match[2].lstrip("0") or "0"):
        raise argparse.ArgumentTypeError(f"must be WIDTHxHEIGHT in pixels, such as 640x360, got {text!r}")
    return int(match[1]), int(match[2])


def _axis(text: str) -> str | None:
    return None if text == "none" else text


def _balancer(text: str) -> Balancer:
    try:
        return by_name(text)
    except ArgumentError as error:
        raise argparse.ArgumentTypeError(f"must be {error.allowed}, got {text!r}") from None


def _space(text: str) -> tuple[float, float] | str | None:
    if text in ("infinite", "fit"):
        return None if text == "infinite" else "fit"
    try:
        low, high = map(float, text.split(","))
    except ValueError:
        allowed = "infinite, fit, or LOW,HIGH in metres, such as -30,30"
        raise argparse.ArgumentTypeError(f"must be {allowed}, got {text!r}") from None
    return low, high
