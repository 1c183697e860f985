"""Every action against McAllister's library: the state of 160 particles before and after one step."""

from __future__ import annotations

import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from standing import on_ranks

SCENE = Path(__file__).parents[1] / "scenes" / "conform.py"
NAME = "mcallister_actions.json"
SCALARS = ("alpha", "mass", "age", "lifetime")


def reference() -> Path | None:
    """Find the file of cases: at MOTES_CONFORMANCE if set, otherwise beside the checkout."""
    told = os.environ.get("MOTES_CONFORMANCE")
    place = Path(told) if told else Path(__file__).resolve().parents[3] / "shared" / "conformance"
    file = place / NAME if place.is_dir() else place
    if file.is_file():
        return file
    assert not told, f"MOTES_CONFORMANCE={told}: there is no {file}"
    return None


FILE = reference()
CASES: list[dict[str, Any]] = json.loads(FILE.read_text())["cases"] if FILE else []


def title(number: int) -> str:
    """Name a case by its number, action and shape."""
    shape = CASES[number]["params"].get("shape", {})
    return "-".join([str(number), CASES[number]["action"], *([shape["type"]] if shape else [])])


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """Run all cases in one job."""
    out = tmp_path_factory.mktemp("conformance") / "results"
    ended = on_ranks(1, SCENE, FILE, out)
    assert ended.code == 0, ended.text
    found: list[dict[str, Any]] = pickle.loads(out.read_bytes())
    return found


def close(got: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Compare with tolerances: the library evaluates other expressions in float32."""
    return np.abs(got.astype(np.float64) - wanted) <= 1e-5 + 1e-4 * np.abs(wanted)


def test_there_are_reference_numbers():
    if FILE is None:
        pytest.skip("no reference numbers: no MOTES_CONFORMANCE, and no ../shared/conformance")
    assert len(CASES) >= 100


@pytest.mark.parametrize("number", range(len(CASES)), ids=title)
def test_like_mcallister(number: int, results: list[dict[str, Any]]):
    case = CASES[number]
    result = results[number]
    assert "error" not in result, result["error"]
    columns = result["columns"]
    ids = columns.pop("id")
    count = len(case["before"]["position"])
    killed = np.array(case.get("killed", [0] * count), bool)
    assert sorted(set(range(count)) - set(ids)) == list(np.flatnonzero(killed))
    for name, got in columns.items():
        wanted = case["after"].get(name)
        if wanted is not None:
            same = close(got, np.array(wanted)[~killed])
            first = ids[np.argwhere(~same)[0][0]] if not same.all() else None
            assert same.all(), f"{name}: {np.count_nonzero(~same)} numbers, first of particle {first}"
            continue
        kept = case["before"].get(name, np.full((count, 3) if name not in SCALARS else count, 0.75))
        assert got.tobytes() == np.array(kept, np.float32)[~killed].tobytes(), f"{name} changed"
