"""The layer "particles": put over a picture without particles, it gives the picture with them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes import shapes
from motes.errors import ArgumentError

SKIES: list[Any] = [(0.1, 0.2, 0.4), motes.Gradient((0.5, 0.3, 0.2), (0.1, 0.2, 0.5), (0.1, 0.1, 0.1))]


def drawn(blend: str, sky: Any, *, count: int = 80, **options: Any) -> motes.Frame:
    """Draw particles before, in and behind a ball."""
    camera = motes.Camera((0, 0.5, 6), (0, 0, 0))
    renderer = motes.Renderer(
        120, 80, camera=camera, background=sky, linear=True, objects=[shapes.Sphere((0, 0, 0), 1)], **options
    )
    world = motes.World(seed=2, renderer=renderer, progress="off")
    kind = "sphere" if blend == "opaque" else "disc"
    system = world.system("s", sprite=motes.Sprite(kind, blend=blend, pixels=None))
    with world:
        system.configure(color=(0.6, 0.4, 0.2), alpha=0.4, size=0.3, velocity=(1, 0, 0))
        system.burst(shapes.Box((-2, -1.2, -2), (2, 1.2, 2)), count=count)
        system.move()
        return world.render()


@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
@pytest.mark.parametrize("sky", SKIES)
def test_over_the_scene_it_is_the_picture(blend: str, sky: Any) -> None:
    whole = drawn(blend, sky, layers=["alpha", "particles"])
    assert whole.digest() == drawn(blend, sky).digest()
    layer = whole.layer("particles")
    assert layer.shape == (80, 120, 4) and layer.dtype == np.float32
    scene = drawn(blend, sky, count=0).linear
    light, alpha = layer[:, :, :3], layer[:, :, 3:]
    assert light.mean() > 0.004 and (light > 0).any(2).mean() < 0.9
    assert (alpha.max() == 0) == (blend == "add")
    assert light + (1 - alpha) * scene == pytest.approx(whole.linear, abs=0.02)
    assert (whole.layer("alpha")[35:45, 55:65] == 1).all(), "the ball"
    assert (layer[:, :, 3] < 0.99).sum() > 2000, "solids are not in it"


def test_it_is_black_without_particles() -> None:
    assert not drawn("alpha", SKIES[1], count=0, layers=["particles"]).layer("particles").any()


RANKED = """
import sys, motes, hashlib
from motes import shapes
renderer = motes.Renderer(120, 80, camera=motes.Camera((0, 0.5, 6), (0, 0, 0)), background=(0.1, 0.2, 0.4),
    objects=[shapes.Sphere((0, 0, 0), 1)], layers=["particles"], path=sys.argv[1], shutter=0.5, bloom=0.1)
world = motes.World(seed=2, renderer=renderer, progress="off", roles="shared", digest=True)
s = world.system("s", sprite=motes.Sprite("disc", pixels=7))
with world:
    for frame in world.frames(3):
        renderer.camera.position = (frame, 0.5, 6)
        s.configure(color=(0.6, 0.4, 0.2), velocity=(1, 0, 0))
        s.source(shapes.Box((-2, -1.2, -2), (2, 1.2, 2)), rate=2000)
        s.move()
        picture = world.render()
        if picture:
            layer = picture.layer("particles")
            print(frame, picture.digest(), hashlib.sha256(layer.tobytes()).hexdigest(), layer.any())
"""


def test_on_any_ranks_and_paths() -> None:
    lines = {
        tuple(on_ranks(ranks, RANKED, path).lines)
        for ranks, path in [(1, "gather"), (2, "composite"), (3, "tiles"), (3, "composite")]
    }
    assert len(lines) == 1 and all(line.endswith("True") for line in lines.pop())


def test_exr_for_compositing(tmp_path: Path) -> None:
    import OpenEXR

    frame = drawn("alpha", SKIES[0], layers=["alpha", "particles"])
    frame.save(tmp_path / "a.exr")
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        channels = file.channels()
        names = {"R", "G", "B", "A", "alpha.A", *(f"particles.{one}" for one in "RGBA")}
        assert set(channels) == names
        assert (channels["A"].pixels == channels["alpha.A"].pixels).all()
        assert channels["A"].pixels == pytest.approx(frame.layer("alpha"), abs=1e-3)
        for i, one in enumerate("RGBA"):
            wanted = frame.layer("particles")[:, :, i]
            assert channels[f"particles.{one}"].pixels == pytest.approx(wanted, abs=1e-3)
    sky = motes.Renderer(8, 8, camera=motes.Camera((0, 0, 5), (0, 0, 0)), background=tmp_path / "a.exr")
    assert sky.background is not None, "a file with A can be a sky"
    with pytest.raises(ArgumentError, match="'particles'"):
        motes.Renderer(8, 8, camera=sky.camera, layers=["particle"])  # type: ignore[list-item]
