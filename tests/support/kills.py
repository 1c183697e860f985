"""Random kills of ranks, each repeatable by its seed: no result is lost, and nothing hangs.

`python tests/support/kills.py --from 0 --seeds 50` runs them and reports which fail. Runs that end are
started again on other numbers of ranks, perhaps with more kills, until the last start, which nobody disturbs.
"""

from __future__ import annotations

import argparse
import functools
import hashlib
import json
import random
import re
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from films import packets
from launching import Hang, Result, command

from motes import open_particles

SCENE = Path(__file__).parents[1] / "scenes" / "killable.py"
FRAMES = 26
STARTS = 3
SENTENCE = re.compile(r"^(\*\*\* motes: |motes run: |motes: )\S.*\S", re.MULTILINE)
Kill = list[Any]


def kills_of(drawn: random.Random, ranks: int) -> list[Kill]:
    """Draw one or two kills."""
    return [_kill(drawn, drawn.randrange(ranks)) for _ in range(drawn.choice([1, 1, 1, 2]))]


def _kill(drawn: random.Random, rank: int) -> Kill:
    place = drawn.choice(["start", "frame", "frame", "frame", "name", "name"])
    if place == "start":
        return [rank, place, 0, drawn.choice([drawn.uniform(0, 300), drawn.uniform(0, 3000)])]
    if place == "frame":
        number = drawn.choice([0, 0, 1, 11, 12, 12, 13, 24, 25, drawn.randrange(FRAMES)])
        return [rank, place, number, drawn.choice([0, drawn.uniform(0, 2), drawn.uniform(0, 40)])]
    return [
        rank,
        place,
        drawn.choice([1, 2, drawn.randrange(1, 12), drawn.randrange(1, 90)]),
        drawn.randrange(2),
    ]


def play(out: Path, ranks: int, mode: str, kills: list[Kill]) -> Result:
    """Run the scene; raises Hang if it does not end."""
    flags = ["--survive"] if "survive" in mode else []
    argv = [sys.executable, "-m", "motes", "run", *flags, "-n", ranks, SCENE, out, mode]
    return command(argv, timeout=150, env={"KILLS": json.dumps(kills)})


def results(out: Path, mode: str) -> dict[str, Any]:
    """Return everything that a run has made, comparable."""
    rows = map(json.loads, (out / "log" / "frames.jsonl").read_text().splitlines())
    found: dict[str, Any] = {
        "log": [(row["frame"], row["particles_digest"], row["image_sha256"]) for row in rows],
        "pictures": {path.name: _sha(path.read_bytes()) for path in sorted(out.glob("*.png"))},
        "film": packets(out / "film.mp4"),
        "left": [path.name for path in (*out.rglob("*.tmp"), *out.glob("*.partial.*")) if not _aside(path)],
    }
    for name in () if mode == "survive" else ("all", "some.pvd"):
        for system in ("grains", "dust"):
            opened = open_particles(out / name, system=system)
            found[f"{name} {system}"] = {
                (frame, column): _sha(values.tobytes())
                for frame, particles in opened.items()
                for column, values in particles.columns("id", *particles.columns()).items()
            }
            found[f"{name} {system} finished"] = opened.finished
    return found


def _aside(path: Path) -> bool:
    """Return whether a file is in a log that was moved aside, just as its run has left it."""
    return re.fullmatch(r"log\.\d+", path.parent.name) is not None


def _sha(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


@functools.cache
def model(folder: str) -> dict[str, Any]:
    """Return the results of an undisturbed run on one rank."""
    out = Path(folder) / "model"
    result = play(out, 1, "restart", [])
    assert result.code == 0, result.text
    return results(out, "restart")


def broken(out: Path, models: Path, seed: int) -> tuple[str, int]:
    """Run a seed's kills; return which promise was broken, or nothing, and how many runs were hit."""
    drawn = random.Random(seed)
    mode = drawn.choice(["restart", "restart", "survive", "survive,export"])
    hit, told = 0, ""
    for start in range(STARTS + 1):
        ranks = drawn.choice([1, 2, 3, 3, 4, 5])
        ranks = max(2, ranks) if mode != "restart" and start < STARTS else ranks
        disturbed = start == 0 or (start < STARTS and drawn.random() < 0.4)
        kills = kills_of(drawn, ranks) if disturbed else []
        told += f"\n--- {ranks} ranks, {mode}, {kills}\n"
        try:
            result = play(out, ranks, mode, kills)
        except Hang as hang:
            return f"it hangs: {hang}{told}", hit
        told += result.text
        hit += result.code != 0 or "motes: lost " in result.err
        if result.code == 0:
            break
        if not kills:
            return f"it cannot be started again{told}", hit
        if ranks > 1 and not SENTENCE.search(result.err):  # nobody is left to report a run of one process
            return f"it ends without a sentence{told}", hit
    try:
        wanted, made = model(str(models)), results(out, mode)
    except Exception as error:  # any error: files may be missing or incomplete
        return f"{type(error).__name__}: {error}{told}", hit
    differ = [name for name in made if made[name] != wanted[name]]
    return (f"{differ} differ{told}" if differ else ""), hit


def main() -> int:
    """Run many seeds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--from", dest="first", type=int, default=0)
    parser.add_argument("--seeds", type=int, default=20)
    args = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="motes-kills-"))
    failed, hits = [], 0
    for seed in range(args.first, args.first + args.seeds):
        told, hit = broken(folder / str(seed), folder, seed)
        hits += hit
        shutil.rmtree(folder / str(seed), ignore_errors=True)
        if told:
            failed.append(seed)
            print(f"seed {seed}: {told}", flush=True)
        print(f"{seed + 1 - args.first} seeds, {hits} runs hit, {len(failed)} failed: {failed}", flush=True)
    shutil.rmtree(folder, ignore_errors=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
