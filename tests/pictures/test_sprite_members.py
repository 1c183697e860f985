"""Sprites of the core: made of the members that all kinds have, and of those of their own kind."""

from __future__ import annotations

from typing import Any

import pytest

from motes import ArgumentError, _core

COMMON = {"pixels": 0, "blend": "add", "of_height": 0, "softness": 0.5, "lit": False, "shadow": 0}
COMMON |= {"roughness": 1, "metal": 0}
RIBBON = COMMON | {"width": 0.1, "length": 2}


def test_a_sprite_is_made_of_the_members_of_its_kind():
    _core.Sprite("disc", **COMMON)
    _core.Sprite("ribbon", **RIBBON)
    for name in RIBBON:
        with pytest.raises(ArgumentError, match=f"{name} must be given"):
            _core.Sprite("ribbon", **{one: value for one, value in RIBBON.items() if one != name})
    for kind, more in (("disc", "width"), ("ribbon", "facing"), ("point", "softnes")):
        given = (RIBBON if kind == "ribbon" else COMMON) | {more: 1}
        with pytest.raises(ArgumentError, match="kind"):
            _core.Sprite(kind, **given)


@pytest.mark.parametrize(
    ("name", "value"),
    [("blend", "adds"), ("softness", -1), ("width", 0), ("length", float("nan")), ("pixels", 513)],
)
def test_members_are_checked_by_name(name: str, value: Any):
    with pytest.raises(ArgumentError, match=name):
        _core.Sprite("ribbon", **(RIBBON | {name: value}))
