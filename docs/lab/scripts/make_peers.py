"""Measure the engine beside other tools: `make_peers.py [--lammps PYTHON] [--simd SET ...] [--busy]`.

Runs `python -m motes bench peers` with each instruction set, writes the figures to peers.json beside it, and
the tables of docs/lab/speed.md from them, with processor, load and date. `--tables` only writes these.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("peers.json")
PAGE = Path(__file__).resolve().parents[1] / "speed.md"
BEGIN, END = "<!-- written by scripts/make_peers.py -->\n", "<!-- end -->\n"
BEDS = {"bed": "at rest", "chute": "chute"}

Figures = Mapping[str, Any]


def measured(options: Sequence[str], simd: str) -> dict[str, Any]:
    """Run the benchmark with an instruction set; return its figures."""
    command = [sys.executable, "-m", "motes", "bench", "peers", "--json", *options]
    done = subprocess.run(
        command, env={**os.environ, "MOTES_SIMD": simd}, check=True, stdout=subprocess.PIPE, text=True
    )
    figures: dict[str, Any] = json.loads(done.stdout)
    return figures


def merged(snow: Figures, beside: Figures) -> dict[str, Any]:
    """Return the figures of a run of snow with those of a run with another Python's LAMMPS."""
    found = {**snow, **{name: beside[name] for name in (*BEDS, "collide")}}
    return {**found, "others": max(snow["others"], beside["others"])}


def head(name: str, every: Mapping[str, Figures], per: str) -> list[str]:
    """Return the head of a table with one pair of columns for each instruction set."""
    cells = [f"{simd}, {per} | times" for simd in every]
    return [f"| {name} | " + " | ".join(cells) + " |", "|---" * (1 + 2 * len(every)) + "|"]


def line(name: str, pairs: Iterator[tuple[float, float]]) -> str:
    """Return a line: for each instruction set a figure, and how many times as long as the engine it takes."""
    return f"| {name} | " + " | ".join(f"{value:.3g} | {ratio:.2f}" for value, ratio in pairs) + " |"


def beds(every: Mapping[str, Figures]) -> Iterator[str]:
    """Yield the table of grains and spheres beside LAMMPS."""
    first = next(iter(every.values()))
    yield from head("grains, LAMMPS " + first["chute"]["lammps"], every, "ns per grain and step")
    for bed, what in BEDS.items():
        of = first[bed]
        for k, row in enumerate(of["rows"]):
            about = (
                f"{what}, {of['grains']} grains, {row['ranks']} rank{'s' * (row['ranks'] > 1)}: {row['peer']}"
            )
            rows = (figures[bed]["rows"][k] for figures in every.values())
            yield line(about, ((one["ns"], one["engine_by_peer"]) for one in rows))
    for k, row in enumerate(first["collide"]["rows"]):
        rows = (figures["collide"]["rows"][k] for figures in every.values())
        about = f"{first['collide']['spheres']} spheres: {row['peer']}"
        yield line(about, ((one["ns"], one["engine_by_peer"]) for one in rows))


def snow(every: Mapping[str, Figures]) -> Iterator[str]:
    """Yield the table of snow's list beside other tools."""
    first = next(iter(every.values()))
    yield from head(f"snow, {first['particles'] / 1e6:.1f} million", every, "M updates/s")
    for k, row in enumerate(first["rows"]):
        rows = (figures["rows"][k] for figures in every.values())
        name = f"{row['peer']} {row['version']}, {row['threads']} thread{'s' * (row['threads'] > 1)}"
        yield line(name, ((one["million_per_s"], one["engine_by_peer"]) for one in rows))


def tables(every: Mapping[str, Figures]) -> str:
    """Return the tables, below a line about the machine and the day."""
    first = next(iter(every.values()))
    used = max(figures["others"] for figures in every.values())
    about = f"{first['processor']}, {first['cores']} cores, {first['date']}; "
    about += f"other programs used {used:.2f} processors."
    return "\n".join([about, "", *beds(every), "", *snow(every)]) + "\n"


def page(text: str, every: Mapping[str, Figures]) -> str:
    """Return the page with these tables."""
    before, _, rest = text.partition(BEGIN)
    return f"{before}{BEGIN}{tables(every)}{END}{rest.partition(END)[2]}"


def main() -> None:
    """Measure, unless only the tables are asked for, and write the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--lammps", metavar="PYTHON", help="a Python that has LAMMPS, if this one has none")
    parser.add_argument("--simd", nargs="+", default=["avx512", "avx2"])
    parser.add_argument("--busy", action="store_true")
    parser.add_argument("--tables", action="store_true")
    args = parser.parse_args()
    if not args.tables:
        busy = ["--busy"] if args.busy else []
        every = {simd: measured(busy, simd) for simd in args.simd}
        if args.lammps:
            beside = ["--lammps", args.lammps, *busy]
            every = {simd: merged(figures, measured(beside, simd)) for simd, figures in every.items()}
        FILE.write_text(json.dumps(every, indent=1) + "\n")
    PAGE.write_text(page(PAGE.read_text(), json.loads(FILE.read_text())))


if __name__ == "__main__":
    main()
