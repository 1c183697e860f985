"""Prims of a stage whose values come from a layer per frame: USD's value clips."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from .._shot.words import asset

__all__ = ["CLIPS", "clipped", "declared"]

CLIPS = ".clips.usda"


def clipped(
    kind: str,
    prim: str,
    path: str,
    lines: Iterable[str],
    stem: str,
    files: Sequence[tuple[int, str]],
    folder: str,
) -> list[str]:
    """Return a prim over the layers of its frames.

    `path`: of the prim in each layer; `lines`: its attributes; `stem`: of the clip manifest; `files`: the
    layer of each frame.
    """
    assets = list(dict.fromkeys(file for _, file in files))
    index = {file: k for k, file in enumerate(assets)}
    active = ", ".join(f"({frame}, {index[file]})" for frame, file in files)
    # Stage time -> the clip's time: constant until the next frame, then a jump.
    ends = [(after, frame) for (frame, _), (after, _) in zip(files, files[1:], strict=False)]
    starts = [(frame, frame) for frame, _ in files]
    times = ", ".join(f"({shown}, {frame})" for shown, frame in sorted([*starts, *ends]))
    return [
        f'def {kind} "{prim}" (',
        "    clips = {",
        "        dictionary default = {",
        f"            double2[] active = [{active}]",
        f"            asset[] assetPaths = [{', '.join(asset(folder, file) for file in assets)}]",
        f"            asset manifestAssetPath = {asset(folder, stem + CLIPS)}",
        f'            string primPath = "{path}"',
        f"            double2[] times = [{times}]",
        "        }",
        "    }",
        ")",
        "{",
        *(f"    {line}" for line in lines),
        "}",
    ]


def declared(kind: str, name: str, interpolation: str = "") -> list[str]:
    """Declare an attribute whose values are in clips; its interpolation cannot come from there."""
    meta = [f"{kind} {name} (", f'    interpolation = "{interpolation}"', ")"]
    return meta if interpolation else [f"{kind} {name}"]
