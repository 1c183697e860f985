"""Libraries begin on the script's thread: where two threads begin one at once, both may wait for ever."""

from __future__ import annotations

import importlib.util

import pytest
from launching import mpirun, python

HAS_USD = importlib.util.find_spec("pxr") is not None

TWO_EXPORTS = """
import sys, motes
from motes.shapes import Sphere

world = motes.World(seed=1, progress="off")
s = world.system("s")
exports = [motes.Export(f"{sys.argv[1]}/{name}.usd") for name in "abc"]
with world:
    for frame in world.frames(int(sys.argv[2])):
        s.burst(Sphere((0, 0, 0), 1), count=10)
        s.move()
        world.step()
        for export in exports:
            export.write(world)
print([len(motes.open_particles(f"{sys.argv[1]}/{name}.usd").frames) for name in "abc"])
"""


@pytest.mark.skipif(not HAS_USD, reason="needs usd-core")
@pytest.mark.parametrize("frames", [4, pytest.param(300, marks=pytest.mark.slow)])
def test_several_exports_to_usd_are_written_at_once(tmp_path, frames):
    result = python(TWO_EXPORTS, tmp_path, frames, timeout=40 + frames)
    assert result.lines == [str([frames] * 3)], result.text


IMPORTS = """
import os, pathlib, sys, threading
late = []

class Watch:
    # Notes which libraries are searched for outside the main thread.

    @staticmethod
    def find_spec(name, path=None, target=None):
        thread = threading.current_thread()
        if thread is not threading.main_thread() and (path is None or name.startswith("pxr.")):
            late.append((thread.name, name))

sys.meta_path.insert(0, Watch)

import motes
from motes.shapes import Sphere

out, names = pathlib.Path(sys.argv[1]), sys.argv[2:]
camera = motes.Camera((0, 0, 3), (0, 0, 0))
world = motes.World(seed=1, progress="off", renderer=motes.Renderer(64, 48, camera=camera),
                    live=motes.Live(0, wait=True) if "live" in names else None,
                    checkpoint=motes.Checkpoint(out / "checkpoints", every=2), log=out / "log")
s = world.system("s")
exports = [motes.Export(out / name) for name in names if name.startswith("export")]
films = [motes.Movie(out / name) for name in names if name.startswith("film")]
with world:
    if "live" in names:
        (out / "part").write_text(world.live_url)
        os.rename(out / "part", out / "url")
    for frame in world.frames(8):
        if frame == int(os.environ.get("KILL", "-1")):
            os._exit(9)
        s.burst(Sphere((0, 0, 0), 1), count=10)
        s.move()
        picture = world.render()
        for export in exports:
            export.write(world)
        for film in films:
            film.write(picture)
        if frame == 7 and "live" in names:
            while not (out / "seen").exists():
                world.redraw()
    for film in films:
        film.close()
packages = {"av", "pxr", "simplejpeg", "websockets", "OpenEXR", "PIL", "pyarrow"}
print("late", [one for one in late if one[1].partition(".")[0] in packages])
"""
FILES = ["exports", "export.pvd", *(["export.usd"] if HAS_USD else []), "film.mp4", "film.mkv"]


def test_no_library_begins_in_a_thread_that_writes_files(tmp_path):
    if importlib.util.find_spec("av") is None:
        pytest.skip("needs PyAV")
    assert python(IMPORTS, tmp_path, *FILES, env={"KILL": "5"}).code == 9
    result = python(IMPORTS, tmp_path, *FILES)  # films and exports go on
    assert "continues with frame" in result.err and result.lines == ["late []"], result.text


def test_no_library_begins_in_a_thread_that_serves_viewers(tmp_path):
    viewers = pytest.importorskip("viewers")

    async def watch() -> None:
        async with viewers.Client.of(await viewers.url_of(tmp_path)) as viewer:
            await viewer.until(lambda: bool(viewer.pictures))
            (tmp_path / "seen").touch()

    with viewers.Beside(watch) as beside:
        result = mpirun(1, IMPORTS, tmp_path, "live", watch=beside.check)
    assert result.lines == ["late []"], result.text
