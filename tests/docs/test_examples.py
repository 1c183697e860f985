"""The examples as a user runs them: small, on one rank and on several."""

from __future__ import annotations

import importlib.util
import json
import math
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numpy.typing import NDArray
from standing import alike, on_ranks

import motes

EXAMPLES = Path(__file__).parents[2] / "examples"
STILLS = Path(__file__).parents[2] / "docs" / "gallery"
FRAMES, SYSTEMS, PARTICLES = 4, 2, 2000
SMALL = ("--systems", SYSTEMS, "--particles", PARTICLES, "--frames", FRAMES, "--size", "160x90", "--digest")
NAMES = ("snow", "fountain")
STANDING = {"snow": 0, "fountain": 123 * 30}  # particles of the fountain's basin
ELSEWHERE = {"snow": "infinite", "fountain": "fit"}


def run(name: str, ranks: int, *arguments: object) -> list[list[str]]:
    """Run an example; return the fields of each line: frame, digests of particles and picture."""
    said = on_ranks(ranks, EXAMPLES / f"{name}.py", *SMALL, *arguments, timeout=40).lines
    lines = [line for line in said if line[0].isdigit()]
    frames = arguments[arguments.index("--frames") + 1] if "--frames" in arguments else FRAMES
    assert [line.split()[0] for line in lines] == [str(frame) for frame in range(int(str(frames)))]
    return [line.split() for line in lines]


def run_with_pictures(name: str, ranks: int, out: Path) -> list[list[str]]:
    """Run an example that makes pictures, and check the files that it wrote."""
    lines = run(name, ranks, "--out", out)
    assert sorted(path.name for path in out.iterdir()) == [f"{name}.mp4", f"{name}.png"]
    assert movie_frames(out / f"{name}.mp4") == FRAMES
    return lines


@cache
def alone(name: str) -> list[list[str]]:
    """Run an example on one rank."""
    with TemporaryDirectory() as out:
        return run_with_pictures(name, 1, Path(out))


def pixels(path: Path) -> NDArray[np.uint8]:
    """Read a picture."""
    av = pytest.importorskip("av")
    with av.open(str(path)) as picture:
        return next(picture.decode(video=0)).to_ndarray(format="rgb24")


def movie_frames(path: Path) -> int:
    """Decode a movie; return the number of frames."""
    av = pytest.importorskip("av")
    with av.open(str(path)) as movie:
        return sum(1 for _ in movie.decode(video=0))


@pytest.mark.parametrize("name", NAMES)
def test_three_ranks_make_the_movie_of_one(name: str, tmp_path: Path):
    assert run_with_pictures(name, 3, tmp_path / "out") == alone(name)
    for column in (1, 2):
        assert len({line[column] for line in alone(name)}) == FRAMES, "each frame differs from the others"


def test_without_pictures_nothing_is_written_and_fountains_exchange_more_than_snow(tmp_path: Path):
    exchanged = {}
    for name in NAMES:
        out, log = tmp_path / "out", tmp_path / name
        lines = run(name, 5, "--no-images", "--out", out, "--log", log)
        assert lines == [[frame, particles, "-"] for frame, particles, _ in alone(name)]
        assert not out.exists()
        rows = [json.loads(line) for line in (log / "frames.jsonl").read_text().splitlines()]
        moving = [row["particles"] - STANDING[name] for row in rows]
        assert all(0.9 * SYSTEMS * PARTICLES < count <= SYSTEMS * PARTICLES for count in moving)
        assert rows[-1]["dropped"] == 0
        exchanged[name] = sum(row["exchanged"] for row in rows)
    assert exchanged["fountain"] > 5 * exchanged["snow"]


@pytest.mark.parametrize("name", NAMES)
def test_another_space_gives_the_same_particles(name: str):
    lines = run(name, 4, "--no-images", "--space", ELSEWHERE[name])
    assert [line[1] for line in lines] == [line[1] for line in alone(name)]


@pytest.mark.parametrize("ranks", [1, 4])
def test_heterogeneous_shows_who_has_how_much(ranks: int, tmp_path: Path):
    pytest.importorskip("pandas")
    small = ("--particles", 6000, "--frames", 9, "--size", "160x90", "--out", tmp_path)
    lines = on_ranks(ranks, EXAMPLES / "heterogeneous.py", *small).lines
    calculators = [2, 3] if ranks == 4 else [0]
    assert movie_frames(tmp_path / "heterogeneous.mp4") == 9
    assert lines[0] == "Each calculator's part of the particles, in %:"
    assert lines[1].split()[1:] == [str(rank) for rank in calculators]
    shares = {int(row.split()[0]): [float(part) for part in row.split()[1:]] for row in lines[3:]}
    assert list(shares) == [0, 4, 8]
    assert all(sum(row) == pytest.approx(100, abs=0.2) for row in shares.values())
    facts = json.loads((tmp_path / "heterogeneous" / "run.json").read_text())
    assert facts["speeds"] == {str(calculators[-1]): 0.5}
    rows = [json.loads(line) for line in (tmp_path / "heterogeneous" / "load.jsonl").read_text().splitlines()]
    last = [row["n_end"] for row in rows if row["frame"] == 8]
    assert shares[8] == pytest.approx([100 * n / sum(last) for n in last], abs=0.1)


@pytest.mark.parametrize("name", ["grains/hopper", "grains/drum", "grains/pegs"])
def test_others_run_and_are_the_same_on_any_ranks(name: str, tmp_path: Path):
    small = ("--particles", 200, "--frames", 2, "--size", "64x36", "--digest", "--out", tmp_path)
    lines = alike(EXAMPLES / f"{name}.py", *small, ranks=(1, 3))
    assert [line.split()[0] for line in lines][:2] == ["0", "1"]


def through_a_slab(photons: int, path: float, thick: float = 2.0) -> float:
    """Return the fraction of photons that pass a half-absorbing slab, by an independent Monte Carlo."""
    rng = np.random.default_rng(3)
    x, cosine = np.zeros(photons), np.ones(photons)
    through = 0
    while len(x):
        x = x + cosine * rng.exponential(path, len(x))
        through += int((x > thick).sum())
        x = x[(x > 0) & (x < thick) & (rng.random(len(x)) < 0.5)]
        cosine = rng.uniform(-1, 1, len(x))
    return through / photons


def test_shielding_obeys_the_law_and_counts_the_same_on_any_ranks():
    arguments = ("--no-images", "--particles", 30_000)
    lines = alike(EXAMPLES / "shielding.py", *arguments, ranks=(1, 3))
    assert len(lines) == 2
    for line, path in zip(lines, (0.5, 1.2), strict=True):
        words = line.replace(",", "").split()
        photons, through, straight, law = int(words[1]), int(words[3]), int(words[5]), float(words[10])
        assert photons == 30_000
        for part, wanted in ((straight, math.exp(-2 / path)), (through, through_a_slab(400_000, path))):
            assert abs(part / photons - wanted) < 4 * math.sqrt(wanted * (1 - wanted) / photons), line
        assert law == pytest.approx(math.exp(-2 / path), abs=1e-4)


def test_export_writes_the_same_embers_on_any_ranks(tmp_path: Path):
    kinds = [".pvd", *([".usd"] if importlib.util.find_spec("pxr") else [])]
    said, files = {}, {}
    for ranks, kind in [(1, ""), (3, ""), *((3, kind) for kind in kinds)]:
        out = tmp_path / str(ranks)
        arguments = (
            "--particles",
            600,
            "--frames",
            12,
            "--every",
            3,
            "--out",
            out,
            "--digest",
            "--kind",
            kind,
        )
        lines = on_ranks(ranks, EXAMPLES / "export.py", *arguments).lines
        said[ranks, kind] = lines[:-1]
        files[ranks, kind] = motes.open_particles(out / f"embers{kind}")
        assert lines[-1].startswith(f"4 frames in {out}/embers{kind}; the last one has 1")
    first = files.pop((1, ""))
    assert first.frames == (0, 3, 6, 9) and len(said[1, ""]) == 12
    for key, other in files.items():
        assert said[key] == said[1, ""]
        for frame, particles in other.items():
            wanted = first[frame].columns("id", *first[frame].columns())
            assert all(particles.columns(name)[name].tobytes() == wanted[name].tobytes() for name in wanted)
    assert 0 <= first[9].heat.min() < first[9].heat.max() <= 1 and first[9].position[:, 1].min() > -0.2


def test_photo_takes_any_picture_and_gives_it_back(tmp_path: Path):
    given = STILLS / "fountain.png"
    run("photo", 3, "--picture", given, "--particles", 14400, "--frames", 12, "--out", tmp_path)
    av = pytest.importorskip("av")
    with av.open(str(tmp_path / "photo.mp4")) as movie:
        first, *_, last = [frame.to_ndarray(format="gray").astype(float) for frame in movie.decode(video=0)]
    fine = pixels(given).mean(axis=2)
    high, wide = fine.shape[0] // 90, fine.shape[1] // 160
    picture = fine.reshape(90, high, 160, wide).mean(axis=(1, 3))
    for frame in (first, last):
        assert np.corrcoef(frame.ravel(), picture.ravel())[0, 1] > 0.5


def test_a_script_has_options_of_its_own():
    own = motes.script.options(
        None, wind=2.5, count=3, sky_color="blue", argv=["--wind", "3", "--sky-color", "red"]
    )
    assert (own.wind, own.count, own.sky_color, own.frames) == (3.0, 3, "red", 96)
    with pytest.raises(SystemExit):
        motes.script.options(None, wind=2.5, argv=["--wind", "strong"])
