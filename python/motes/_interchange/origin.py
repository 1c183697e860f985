"""The origin of an export: the script, its arguments and the settings that decide its particles.

A run continues or replaces only the export of an earlier start of the same script, as with checkpoints.
"""

from __future__ import annotations

from typing import Any

from .._run import same_script
from .._run.settings import RunSettings
from .._values.space import ends_of
from .manifest import Manifest, SystemColumns

__all__ = ["PACKED", "difference", "origin_of", "unlike_systems"]


def origin_of(settings: RunSettings, *, scene: bool) -> dict[str, Any]:
    """Return the facts for a manifest; the script's text is represented by its hash."""
    script = {name: fact for name, fact in same_script.facts().items() if name != "text"}
    seeded = {"substeps": settings.substeps, "periodic": ends_of(settings.periodic)}
    drawn = {"scene": True} if scene else {}
    return {**seeded, **drawn, "seed_given": settings.seed_given, "script": script}


PACKED: dict[str, Any] = {
    **{"substeps": 1, "periodic": {}, "seed_given": False},
    "script": {"path": "python -m motes pack", "sha256": "", "arguments": []},
}
"""The origin of what `pack` writes. It names no source, so that equal particles make equal files."""


def difference(then: Manifest, now: Manifest, *, first: int, anyway: bool = False) -> str:
    """Describe how an earlier export differs from the one that a run writes; "" if they are the same.

    `first`: the first frame that the run writes; `anyway`: what comes before it may be from another script.
    """
    if then.origin is None or now.origin is None:
        return "its manifest.json does not say which script made it"
    try:
        drawn = not (first or now.origin["seed_given"] or then.origin["seed_given"])
        pairs = [("seed", then.seed, then.seed if drawn else now.seed), ("dt", then.dt, now.dt)]
        pairs += [(name, then.origin[name], now.origin[name]) for name in ("substeps", "periodic")]
        pairs += [("scene", then.origin.get("scene", False), now.origin.get("scene", False))]
        script = same_script.difference(then.origin["script"], now.origin["script"])
    except (KeyError, TypeError) as error:
        return f"its manifest.json is damaged: {error!r}"
    return (
        same_script.changed_setting(pairs)
        or ("" if anyway and first else script)
        or unlike_systems(then.systems, now.systems)
    )


def unlike_systems(then: list[SystemColumns], now: list[SystemColumns]) -> str:
    """Describe the first difference between the systems that both lists have; "" if there is none."""
    for one, other in zip(then, now, strict=False):
        if one.outline() != other.outline():
            return f"its system {one.name!r} has other columns, or is {other.name!r} now"
    return ""
