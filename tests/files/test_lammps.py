"""open_particles of LAMMPS' text dumps."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

import motes
from motes.errors import ArgumentError, MotesError, MotesWarning

BOX = "pp pp pp\n-1 3\n0 2\n10 14"
TILTED = "xy xz yz pp pp pp\n-1.6 3.7 0.7\n-2 2.3 -0.6\n0.5 4 0.3"  # as LAMMPS wrote it
GENERAL = "abc origin\n2 0 0 5\n0 3 0 6\n1 0 4 7"


def step(number: int, columns: str, atoms: str, box: str = BOX, head: str = "") -> str:
    """Return a step as LAMMPS writes it."""
    count = len(atoms.strip().splitlines())
    return (
        f"{head}ITEM: TIMESTEP\n{number}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS {box}\n"
        f"ITEM: ATOMS {columns}\n{atoms.strip()}\n"
    )


def opened(path: Path, text: str) -> motes._interchange.reading.ParticleFiles:  # type: ignore[name-defined]
    """Write a dump, and open it."""
    path.write_bytes(gzip.compress(text.encode()) if path.suffix == ".gz" else text.encode())
    return motes.open_particles(path)


@pytest.mark.parametrize("name", ["dump.melt", "melt.lammpstrj", "melt.dump.gz"])
def test_steps_of_a_custom_dump(tmp_path: Path, name: str) -> None:
    """Frames have the numbers of the steps; atoms are sorted by id; vectors are joined."""
    columns = "id type radius xu vy vx vz c_pe[1] yu zu"
    text = step(0, columns, "7 2 0.5 1 20 10 30 -4 2 3\n3 1 1 4 0 0 0 5 5 6")
    text += step(100, columns, "3 1 1 4.5 0 0 0 5 5 6")
    files = opened(tmp_path / name, text)
    assert files.frames == (0, 100) and files.times == (0, 100) and files.finished
    assert (files.count(0), files.count(-1)) == (2, 1)
    first = files[0]
    assert first.id.tolist() == [3, 7] and first.id.dtype == np.uint64
    assert first.position.tolist() == [[4, 5, 6], [1, 2, 3]]
    assert first.velocity.tolist() == [[0, 0, 0], [10, 20, 30]]
    assert first.size.tolist() == [[2] * 3, [1] * 3]  # diameters
    assert first.c_pe_1.tolist() == [5, -4] and first.type.tolist() == [1, 2]
    assert files[100].position.tolist() == [[4.5, 5, 6]]


def test_coordinates_of_all_kinds(tmp_path: Path) -> None:
    """Fractions of the box become lengths, also in tilted boxes; unwrapped ones stay."""
    for columns, box, expected in (
        ("xs ys zs", BOX, (0, 1.5, 11)),
        ("xsu ysu zsu", BOX, (0, 1.5, 11)),
        ("xs ys zs", TILTED, (-1 + 0.25 * 4 + 0.75 * 0.7 - 0.25 * 0.6, -2 + 3 + 0.25 * 0.3, 1.375)),
        ("xs ys zs", GENERAL, (5 + 0.5 + 0.25, 6 + 2.25, 7 + 1)),
        ("x y z", TILTED, (0.25, 0.75, 0.25)),
        ("xu yu zu", BOX, (0.25, 0.75, 0.25)),
    ):
        files = opened(tmp_path / "one.dump", step(5, columns, "0.25 0.75 0.25", box))
        assert np.allclose(files[5].position, [expected], atol=1e-6), columns
        assert files[5].id.tolist() == [0]
    flat = opened(tmp_path / "one.dump", step(5, "id x y", "9 1 2"))
    assert flat[5].position.tolist() == [[1, 2, 0]]


def test_times_texts_and_steps_written_again(tmp_path: Path) -> None:
    """ITEM: TIME is the frame's time; elements are left out; a continued run replaces its first steps."""
    head = "ITEM: UNITS\nlj\nITEM: TIME\n{}\n"
    text = step(0, "id element x y z", "1 Ar 0 0 0", head=head.format(0))
    text += step(10, "id element x y z", "1 Ar 1 0 0", head=head.format(0.05))
    text += step(10, "id element x y z", "1 Ar 2 0 0", head=head.format(0.05))
    with pytest.warns(MotesWarning, match="'element' is left out: it has texts") as warned:
        files = opened(tmp_path / "one.dump", text)
    assert Path(warned[0].filename).name == Path(__file__).name
    assert files.times == (0, 0.05)
    assert files[10].position.tolist() == [[2, 0, 0]]


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("cut", [1, 4, 40, 60])
def test_a_step_that_was_cut_off_is_left_out(tmp_path: Path, packed: bool, cut: int) -> None:
    """As with other files of killed runs, what is complete can be read."""
    text = (step(0, "id x y z", "1 0 0 0\n2 1 1 1") + step(1, "id x y z", "1 0 0 0\n2 1 1 1")).encode()
    path = tmp_path / "one.dump"
    path.write_bytes(gzip.compress(text[:-cut])[:-9] if packed else text[:-cut])
    files = motes.open_particles(path)
    assert files.frames == (0,) and not files.finished


def test_what_cannot_be_read_is_named(tmp_path: Path) -> None:
    """Damage before the last step, dumps of other things, atoms without places."""
    good = step(0, "id x y z", "1 0 0 0")
    for text, said in (
        (step(0, "id x y z", "1 0 0") + step(1, "id x y z", "1 0 0 0"), "has atoms without 4 values"),
        (good + "nonsense\n" + good, "damaged near byte"),
        (good.replace("-1 3", "-1 b") + good, "damaged near byte"),
        ("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\n", "it has no atoms, but 'NUMBER OF ENTRIES'"),
        (step(0, "id type", "1 1"), "no coordinates x, xu, xs or xsu"),
        ("ITEM: TIMESTEP\n", "no complete step"),
    ):
        with pytest.raises(MotesError, match=said):
            opened(tmp_path / "bad.dump", text)
    with pytest.raises(ArgumentError, match="path must be a name ending in"):
        opened(tmp_path / "bad.dump", "TIMESTEP\n")


def test_particles_of_a_dump_can_be_emitted(tmp_path: Path) -> None:
    """Columns that a system has arrive as they are."""
    files = opened(tmp_path / "one.dump", step(0, "id x y z vx vy vz radius", "1 1 2 3 4 5 6 0.5"))
    world = motes.World(seed=1, progress="off")
    system = world.system("atoms")
    with world:
        system.emit(files[0])
        world.step()
        back = system.gather()
    assert back is not None
    assert (back.position.tolist(), back.velocity.tolist()) == ([[1, 2, 3]], [[4, 5, 6]])
    assert back.size.tolist() == [[1, 1, 1]]
