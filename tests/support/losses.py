"""Random losses of ranks, each repeatable by its seed, and checks that results are unaffected.

`python tests/support/losses.py --from 0 --seeds 50` runs them and reports which fail.

A rank can die before or after any call that sends something to other ranks or writes to disk, in either of
two worlds. So ranks are also lost between two frames while files are written, after the last frame, and in a
second world.
"""

from __future__ import annotations

import argparse
import functools
import json
import random
import re
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from films import packets
from launching import Hang, Result, command
from numpy.typing import NDArray
from scenes.losing_places import PLACES

from motes import _core, open_particles
from motes._checkpoint import folder
from motes._checkpoint.manifest import Manifest

SCENE = Path(__file__).parents[1] / "scenes" / "losing.py"
FRAMES = 13
EVERY = 5
Plan = dict[str, Any]

# With several ranks gone, replicas may be lost with their holders, and Open MPI 5.0 may crash itself.
SEVERAL = r"lost together with the next one|segmentation fault|replicas of particles do not go back that far"
# Some losses end the run: docs/checkpoints.md, "Without a restart".
EXPORTED = r"lack the lost ranks' particles"
UNSTARTED = r"is lost \(killed or crashed\)|is lost: its process was killed|was killed or has crashed"


def plan_of(seed: int) -> tuple[int, Plan]:
    """Return the number of ranks and the plan of a seed."""
    drawn = random.Random(seed)
    ranks = drawn.choice([2, 3, 3, 4, 4, 5])
    plan: Plan = {
        "worlds": drawn.choice([1, 1, 2]),
        "frames": FRAMES,
        "checkpoint": drawn.choice([0, EVERY, EVERY, EVERY]),
        "film": drawn.choice(["inside", "inside", "inside", "forgotten"]),
        "export": drawn.random() < 0.2,
        "live": drawn.random() < 0.1,
    }
    plan["deaths"] = [death(drawn, ranks, plan)]
    if ranks > 2 and drawn.random() < 0.3:
        other = death(drawn, ranks, plan)
        plan["deaths"] += [other] if other[0] != plan["deaths"][0][0] else []
    return ranks, plan


def death(drawn: random.Random, ranks: int, plan: Plan) -> list[Any]:
    """Draw when and where a rank dies: somewhere in a frame, or at a call that this rank makes."""
    world = drawn.randrange(plan["worlds"])
    if drawn.random() < 0.25:
        return [
            drawn.randrange(ranks),
            world,
            "before the frame",
            1 + drawn.randrange(FRAMES),
            drawn.randrange(1, 30),
        ]
    possible = [
        name
        for name, (_, who, _) in PLACES.items()
        if (plan["checkpoint"] or "checkpoint" not in name) and (plan["export"] or "export" not in name)
    ]
    name = drawn.choice(possible)
    _, who, most = PLACES[name]
    draws, manages = 0, min(1, ranks - 1) if ranks > 2 else 0
    rank = {"draws": draws, "manages": manages}.get(who, drawn.randrange(ranks))
    if "export" in name:
        world = plan["worlds"] - 1
    place = f"{drawn.choice(['before', 'behind'])} {name}"
    return [rank, world, place, 1 + drawn.randrange(most), drawn.choice([0, 0, 0, 1, 3, 9])]


def play(out: Path, ranks: int, plan: Plan) -> Result:
    """Run the scene; raises Hang if it does not end."""
    arguments = ["-m", "motes", "run", "--survive", "-n", ranks, SCENE, out, json.dumps(plan)]
    return command([sys.executable, *arguments], timeout=60)


# --- results


def rows_of(here: Path) -> list[tuple[int, str, str]]:
    """Return each frame's digests of particles and picture from the log."""
    rows = map(json.loads, (here / "log" / "frames.jsonl").read_text().splitlines())
    return [(row["frame"], row["particles_digest"], row["image_sha256"]) for row in rows]


def kinds_of(here: Path) -> list[str]:
    """Return the kinds of the log's events."""
    return [json.loads(row)["kind"] for row in (here / "log" / "events.jsonl").read_text().splitlines()]


def saved_in(here: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the facts of the last checkpoint, and its particles in the order of their ids."""
    place = folder.whole(here / "checkpoints")[0][1]
    manifest = Manifest.from_bytes((place / folder.MANIFEST).read_bytes(), place)
    parts = [planes_of(place / part.file) for part in manifest.parts if part.rows[0] > 0]
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    order = np.argsort(joined["id"])
    movies = {Path(name).name: count for name, count in manifest.movies.items()}
    facts = {
        "frame": manifest.frame,
        "movies": movies,
        "particles": manifest.particles,
        "kept": sorted(manifest.unpacked(place)),
    }
    return facts, {name: plane[order] for name, plane in joined.items()}


def planes_of(file: Path) -> dict[str, NDArray[Any]]:
    """Return the columns of a part that has particles; what is the same for all of them is one row there."""
    content = file.read_bytes()
    length = int.from_bytes(content[:8], "little")
    header = json.loads(content[8 : 8 + length])

    def plane(name: str) -> NDArray[Any] | None:
        facts = header.get(f"sparks/{name}")
        if facts is None:
            return None
        first, last = facts["data_offsets"]
        kind = np.uint64 if name == "id" else np.float32
        return np.frombuffer(content[8 + length :][first:last], kind)

    ids = plane("id")
    assert ids is not None
    found: dict[str, NDArray[Any]] = {"id": ids}
    for name, width in _core.builtin_attributes():
        parts = [plane(f"{name}.{axis}") for axis in "xyz"[:width]] if width > 1 else [plane(name)]
        if parts[0] is None:
            parts = [plane(name)]
        columns = np.stack([part for part in parts if part is not None], axis=-1)
        found[name] = np.broadcast_to(columns.reshape(-1, width), (len(ids), width))
    return found


def difference(here: Path, model: Path, plan: Plan) -> str:
    """Describe the first result of a world that differs from the model's; empty if all are the same."""
    if rows_of(here) != rows_of(model):
        return "the log's rows differ"
    pictures = sorted(path.name for path in model.glob("*.png"))
    if pictures != sorted(path.name for path in here.glob("*.png")):
        return "pictures are missing"
    if any((here / name).read_bytes() != (model / name).read_bytes() for name in pictures):
        return "a picture differs"
    kinds = kinds_of(here)
    if kinds[0] != "start" or kinds[-1] != "end":
        return f"the log's events are {kinds}"
    if plan["checkpoint"]:
        (facts, planes), (expected, its) = saved_in(here), saved_in(model)
        if facts != expected or planes.keys() != its.keys():
            return f"the checkpoint is {facts}, not {expected}"
        if any(planes[name].tobytes() != its[name].tobytes() for name in its):
            return "the checkpoint's particles differ"
        left = [path.name for path in (here / "checkpoints").iterdir() if path.name.endswith(".tmp")]
        if left:
            return f"unfinished checkpoints are left: {left}"
    if packets(here / "film.mp4") != packets(model / "film.mp4"):
        return "the film differs"
    if (here / "film.partial.mp4").exists():
        return "the partial film is left"
    if plan["export"] and here.name == str(plan["worlds"] - 1) and exported(here) != exported(model):
        return "the export differs"
    return ""


def exported(here: Path) -> list[bytes]:
    """Return the particles of each frame of an export, in the order of their ids."""
    frames = []
    for particles in open_particles(here / "points").values():
        order = np.argsort(particles.id)
        frames.append(b"".join(plane[order].tobytes() for _, plane in sorted(particles.columns().items())))
    return frames


@functools.cache
def model(folder_name: str, checkpoint: int, film: str) -> Path:
    """Return the results of an undisturbed run on one rank; computed once."""
    out = Path(folder_name) / f"model-{checkpoint}-{film}"
    plan = {"worlds": 2, "frames": FRAMES, "checkpoint": checkpoint, "film": film, "export": "all"}
    result = play(out, 1, {**plan, "live": False, "deaths": []})
    assert result.code == 0, result.text
    return out


def broken(out: Path, models: Path, seed: int) -> str:
    """Run a seed's losses; return which promise was broken, or nothing."""
    ranks, plan = plan_of(seed)
    try:
        result = play(out, ranks, plan)
    except Hang as hang:
        return f"it hangs: {hang}"
    try:
        told = judged(result, out, model(str(models), plan["checkpoint"], plan["film"]), plan)
    except Exception as error:  # any error: files may be missing or incomplete
        told = f"{type(error).__name__}: {error}"
    return f"{told}: {plan} on {ranks}\n{result.text}" if told else ""


def judged(result: Result, out: Path, expected: Path, plan: Plan) -> str:
    """Return which promise a run has broken; nothing if it has kept all."""
    if result.code != 0:
        allowed = [UNSTARTED] if any(unstarted(one, plan) for one in plan["deaths"]) else []
        allowed += [SEVERAL] if len(plan["deaths"]) > 1 else []
        allowed += [EXPORTED] if plan["export"] else []
        told = any(re.search(sentence, result.err) for sentence in allowed)
        return "" if told else "it ended"
    for number in range(plan["worlds"]):
        here = out / str(number)
        if found := difference(here, expected / str(number), plan):
            return f"world {number}: {found}"
    return ""


def unstarted(dies: list[Any], plan: Plan) -> bool:
    """Return whether a rank may be lost while a world starts, or before the first one."""
    _, world, place, _, ms = dies
    late = ("end", "leave", "close", "name", "last checkpoint", "wait", "report", "manifest")
    return place.endswith(("the run", "the meeting")) or (
        ms > 0 and world + 1 < plan["worlds"] and place.endswith(late)
    )


def main() -> int:
    """Run many seeds, and print which fail."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--from", type=int, default=0, dest="first")
    parser.add_argument("--seeds", type=int, default=20)
    args = parser.parse_args()
    count = 0
    with tempfile.TemporaryDirectory(prefix="motes-losses-") as place:
        for seed in range(args.first, args.first + args.seeds):
            out = Path(place) / str(seed)
            if told := broken(out, Path(place), seed):
                count += 1
                print(f"seed {seed}: {told}", flush=True)
            shutil.rmtree(out, ignore_errors=True)
            print(f"seed {seed}: done, {count} broke a promise", file=sys.stderr, flush=True)
    print(f"{args.seeds} seeds from {args.first}: {count} broke a promise")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
