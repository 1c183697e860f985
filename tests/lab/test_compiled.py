"""The laboratory's compiled part, and a core that was built without it."""

from __future__ import annotations

import importlib
import sys

import pytest

import motes
from motes import _core


def test_the_core_without_the_laboratory_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(_core, "lab", raising=False)
    monkeypatch.delitem(sys.modules, "motes_lab.compiled", raising=False)
    with pytest.raises(motes.MotesError, match=r"^this build of motes has no laboratory: .*-DMOTES_LAB=ON"):
        importlib.import_module("motes_lab.compiled")


def test_benchmarks_and_disasters_are_in_it() -> None:
    from motes_lab import compiled

    assert compiled.__name__ == "motes._core.lab"
    assert {"render_bench", "disaster", "damaged_file"} <= set(vars(compiled))
    assert not [name for name in vars(_core) if name.endswith("_bench") or name == "disaster"]
