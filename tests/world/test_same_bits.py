"""Particles and pictures depend only on the script and its seed.

They do not depend on ranks, roles, cuts, instruction sets, the C library's choice of functions, or other
libraries' arithmetic.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from launching import mpirun, python
from same_bits import EVERYTHING, alone, assert_equal, assert_same, expected, roles, table, widths
from standing import on_ranks

SPACES = (None, [-3, 3], "fit")


def test_the_scene_lives():
    rows = expected()
    assert len({row[0] for row in rows}) == len(rows), "particles change from frame to frame"
    pictures = [row[1] for row in rows if row[1] != "-"]
    assert len(set(pictures)) == len(pictures) > 8
    assert [int(count) for count in rows[-1][2].split(",")][1] == 900, "the capacity is reached"


def test_another_seed_substeps_or_axis():
    variants: list[dict[str, Any]] = [
        {"roles": "auto", "space": None, **change} for change in ({"seed": 1}, {"substeps": 1}, {"axis": "z"})
    ]
    frames = alone(json.dumps(variants))
    last = len(expected()) - 1
    assert len({frames[0, last][0], frames[1, last][0], expected()[last][0]}) == 3
    assert frames[2, last] == expected()[last], "the axis of the domains changes nothing"


@pytest.mark.parametrize("size", [1, pytest.param(2, marks=pytest.mark.slow), 3, 5])
def test_any_ranks_roles_and_cuts(size: int):
    variants = [{"roles": wish, "space": space} for wish in roles(size) for space in SPACES]
    variants.append({"roles": "shared", "space": [-1, 2], "axis": "y"})
    assert_same(size, variants)


@pytest.mark.parametrize(
    "size", [pytest.param(1, marks=pytest.mark.slow), 2, pytest.param(3, marks=pytest.mark.slow), 5]
)
def test_bricks_and_parts_of_the_ids(size: int):
    variants = [
        {"roles": wish, "space": space, "axis": axis, "balance": True, "births": births}
        for wish in ("auto", "shared")
        for axis, space, births in (
            ("xz", None, "manager"),
            ("yx", [-3, 3], "calculators"),
            ("xyz", "fit", "calculators"),
            (None, None, "manager"),
            (None, None, "calculators"),
        )
    ]
    assert_same(size, variants)


@pytest.mark.parametrize(
    "size", [pytest.param(3, marks=pytest.mark.slow), 5, pytest.param(9, marks=pytest.mark.slow)]
)
def test_any_way_of_talking(size: int):
    ways = [("manager", 1, None), ("calculators", 2, "fit"), ("calculators", 8, [-1, 2])]
    variants = [
        {"roles": wish, "space": space, "births": births, "fan_out": fan_out}
        for wish in roles(size)[:: 2 if size > 5 else 1]
        for births, fan_out, space in ways
    ]
    assert_same(size, variants)


@pytest.mark.parametrize(
    ("size", "threads"),
    [
        (1, 7),
        (3, 2),
        pytest.param(1, 2, marks=pytest.mark.slow),
        pytest.param(2, 3, marks=pytest.mark.slow),
        pytest.param(5, 3, marks=pytest.mark.slow),
    ],
)
def test_any_threads(size: int, threads: int):
    variants = [{"roles": wish, "space": [-3, 3]} for wish in ("auto", "shared")]
    env = {"MOTES_THREADS": str(threads), "MOTES_GRAIN": "64"}
    assert_equal(
        table(on_ranks(size, EVERYTHING, json.dumps(variants), timeout=120, env=env).lines), variants
    )


@pytest.mark.parametrize("width", ["sse2", "avx2", "avx512", "neon"])
def test_any_vector_width(width: str):
    if width not in widths():
        pytest.skip(f"this processor has no {width}")
    variants = [{"roles": "auto", "space": None}]
    assert_equal(
        table(on_ranks(1, EVERYTHING, json.dumps(variants), env={"MOTES_SIMD": width}).lines), variants
    )


MIXED = """
import os
import runpy
import sys

rank = int(os.environ.get("PMIX_RANK") or os.environ["PMI_RANK"])
os.environ["MOTES_SIMD"] = sys.argv.pop(1).split(",")[rank]
runpy.run_path(sys.argv.pop(1), run_name="__main__")
from motes import _core
print(rank, _core.simd(), file=sys.stderr, flush=True)
"""


@pytest.mark.parametrize("size", [3, 5])
def test_ranks_of_different_vector_widths(size: int):
    """A cluster of mixed processors: the manager, the image generator and the calculators differ."""
    if len(widths()) < 2:
        pytest.skip("this processor has only one width")
    chosen = [widths()[-1 - rank % len(widths())] for rank in range(size)]
    variants = [{"roles": wish, "space": [-3, 3]} for wish in ("auto", "shared")]
    made = mpirun(size, MIXED, ",".join(chosen), EVERYTHING, json.dumps(variants))
    assert_equal(table(made.lines), variants)
    assert sorted(made.err.splitlines()) == [f"{rank} {name}" for rank, name in enumerate(chosen)], made.text


def test_another_processor_by_the_c_library():
    # The C library then picks its functions for an old processor; ours do not depend on them.
    tunables = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F"}
    variants = [{"roles": "auto", "space": "fit"}]
    assert_same(1, variants, tunables)


def test_a_fast_math_library_in_the_process(tmp_path: Path):
    compiler = next((found for name in ("gcc", "cc", "clang") if (found := shutil.which(name))), None)
    if compiler is None:
        pytest.skip("needs a C compiler")
    source, library = tmp_path / "fast.c", tmp_path / "libfast.so"
    source.write_text("double fast(double x) { return x * 2; }\n")
    argv = [compiler, "-O2", "-ffast-math", "-shared", "-fPIC", str(source), "-o", str(library)]
    subprocess.run(argv, check=True, timeout=60)
    probe = "import ctypes, sys; ctypes.CDLL(sys.argv[1]); x = float('5e-324'); print(x * float('1') == 0)"
    if python(probe, library).out.strip() != "True":
        pytest.skip("this compiler's -ffast-math leaves denormal numbers alone")
    variants = [{"roles": "auto", "space": None}]
    assert_equal(table(python(EVERYTHING, json.dumps(variants), library).lines), variants)


# --- random scripts


def random_scripts(count: int, seed: int) -> list[dict[str, Any]]:
    """Draw scripts as plain values: systems, and the calls of each frame."""
    rng = np.random.default_rng(seed)

    def vector(low: float, high: float) -> list[float]:
        return [float(v) for v in rng.uniform(low, high, 3).astype(np.float32)]

    def shape() -> list[Any]:
        kind = str(rng.choice(["Point", "Line", "Rectangle", "Disc", "Plane", "Box", "Sphere"]))
        radius = float(rng.uniform(0.1, 2))
        low = vector(-2, 1)
        numbers: dict[str, list[Any]] = {
            "Point": [vector(-2, 2)],
            "Line": [vector(-2, 2), vector(-2, 2)],
            "Rectangle": [vector(-2, 2), [1.0, 0.2, 0.0], [0.1, 1.5, 0.3]],
            "Disc": [vector(-2, 2), vector(0.1, 1), radius, radius * float(rng.uniform(0, 1))],
            "Plane": [vector(-2, 0), vector(0.1, 1)],
            "Box": [low, [v + float(rng.uniform(0, 2)) for v in low]],
            "Sphere": [vector(-1, 1), radius, radius * float(rng.uniform(0, 1))],
        }
        return [kind, *numbers[kind]]

    def surface() -> list[Any]:
        while (chosen := shape())[0] in ("Point", "Line"):
            pass
        return chosen

    def call() -> list[Any]:
        calls: list[list[Any]] = [
            ["source", {"rate": float(rng.uniform(0, 2000)), "jitter": bool(rng.integers(2))}, shape()],
            ["burst", {"count": int(rng.integers(0, 60))}, shape()],
            ["emit", {"position": [vector(-3, 3) for _ in range(int(rng.integers(1, 9)))]}],
            ["configure", {"velocity": ["Uniform", vector(-6, 0), vector(0, 6)]}],
            ["configure", {"velocity": vector(-6, 6), "lifetime": ["Uniform", 0.05, 0.5]}],
            ["configure", {"color": ["Normal", vector(0, 1), vector(0, 1)], "up": vector(-1, 1)}],
            ["gravity", {"acceleration": vector(-20, 20)}],
            ["damping", {"damping": vector(0, 1), "min_speed": float(rng.uniform(0, 2))}],
            ["random_acceleration", {}, shape()],
            ["random_velocity", {}, shape()],
            [
                "bounce",
                {"restitution": float(rng.uniform(0, 1)), "friction": float(rng.uniform(0, 1))},
                surface(),
            ],
            ["sink", {"inside": True}, shape()],
            ["sink", {"inside": False}, ["Box", [-5.0, -5.0, -5.0], [5.0, 5.0, 5.0]]],
            ["kill_old", {"age_limit": float(rng.uniform(0.05, 1))}],
            ["kill_expired", {}],
            ["curl_noise", {"strength": 9.0, "scale": 0.7, "octaves": 2, "speed": float(rng.uniform(0, 5))}],
            ["local", {}],
            ["digest", {}],
            ["gather", {}],
            ["move", {"rotational": bool(rng.integers(2))}],
            ["move", {"rotational": True}],
        ]
        return calls[int(rng.integers(len(calls)))]

    scripts = []
    for _ in range(count):
        systems = [
            {
                "capacity": [None, int(rng.integers(10, 400))][int(rng.integers(2))],
                "axis": str(rng.choice(["x", "y", "z"])),
                "space": [None, [-2.0, 2.0], "fit"][int(rng.integers(3))],
            }
            for _ in range(int(rng.integers(1, 4)))
        ]
        first = [["source", {"rate": 1500.0, "jitter": True}, ["Box", [-2.0, -2.0, -2.0], [2.0, 2.0, 2.0]]]]
        calls = [
            [first + [call() for _ in range(int(rng.integers(1, 9)))] for _ in systems] for _ in range(2)
        ]
        scripts.append(
            {
                "seed": int(rng.integers(2**62)),
                "substeps": int(rng.integers(1, 4)),
                "systems": systems,
                "calls": calls,  # of even and of odd frames
                "roles": str(rng.choice(["auto", "shared"])),
            }
        )
    return scripts


def assert_scripts_agree(tmp_path: Path, count: int, seed: int) -> None:
    """Run random scripts on one rank and on several, and compare all particles after every frame."""
    scripts = random_scripts(count, seed)
    path = tmp_path / "scripts.json"
    path.write_text(json.dumps(scripts))
    player = EVERYTHING.parent / "player.py"
    one = on_ranks(1, player, path, timeout=300).lines
    assert len(one) == count
    for size in (3, 4):
        several = on_ranks(size, player, path, timeout=300).lines
        wrong = [i for i in range(count) if one[i] != several[i]]
        if wrong:
            first = wrong[0]
            shown = f"{one[first]}\n{several[first]}\n{json.dumps(scripts[first])}"
            pytest.fail(
                f"scripts {wrong} of seed {seed} differ on {size} ranks; the first:\n{shown}", pytrace=False
            )


def test_random_scripts(tmp_path: Path):
    assert_scripts_agree(tmp_path, 15, seed=7)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_many_random_scripts(tmp_path: Path, seed: int):
    assert_scripts_agree(tmp_path, 60, seed=1000 + seed)


if __name__ == "__main__":  # for viewing one script by hand
    print(json.dumps(random_scripts(1, int(os.environ.get("SEED", "7"))), indent=1))
