"""Columns sorted by id: the same order as NumPy's stable sort for any ids, and rows keep their bits."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motes import _core
from motes._particles import by_id

HIGHEST = 2**64 - 1


@st.composite
def ids(draw) -> np.ndarray:
    near = st.integers(0, 40)
    start = draw(st.sampled_from([0, 2**32 - 5, 2**63 - 7, HIGHEST - 40]))
    numbers = draw(st.lists(st.one_of(near.map(lambda n: start + n), st.integers(0, HIGHEST)), max_size=50))
    return np.array(numbers, np.uint64)


@given(ids())
def test_the_order_is_that_of_a_stable_sort(ids):
    order = by_id.order(ids)
    if order is None:
        assert (ids[1:] > ids[:-1]).all()
    else:
        assert order.dtype == np.int64 and (order == np.argsort(ids, kind="stable")).all()


def test_ids_that_ascend_need_no_order():
    assert by_id.order(np.array([1, 5, HIGHEST], np.uint64)) is None
    assert by_id.order(np.empty(0, np.uint64)) is None


@given(st.integers(1, 100), st.sampled_from([("f4", (3,)), ("f4", ()), ("u8", ())]), st.randoms())
def test_rows_are_taken_with_their_bits(count, form, random):
    kind, inner = form
    data = random.randbytes(count * np.dtype((kind, inner)).itemsize)
    column = np.frombuffer(data, kind).reshape(count, *inner)
    order = np.array(random.sample(range(count), count), np.int64)
    rows = np.empty_like(column)
    _core.take_rows(column, order, rows)
    assert rows.tobytes() == column[order].tobytes()


@pytest.mark.parametrize("order, error", [([0, 2], IndexError), ([0, -1], IndexError), ([0], ValueError)])
def test_rows_that_there_are_not(order, error):
    with pytest.raises(error, match="take_rows"):
        _core.take_rows(np.zeros(2, np.float32), np.array(order, np.int64), np.zeros(2, np.float32))


def test_rows_of_other_sizes_and_rows_with_gaps_are_refused():
    gaps = np.zeros((2, 6), np.float32)[:, ::2]
    with pytest.raises(ValueError, match="C order"):
        _core.take_rows(gaps, np.array([1, 0]), np.zeros((2, 3), np.float32))
    with pytest.raises(ValueError, match="4, 8, 12 or 16 bytes"):
        _core.take_rows(np.zeros(2, np.int16), np.array([1, 0]), np.zeros(2, np.int16))


USD = """
import json, os
from motes import _extras
_extras.usd_writer("a test")
from pxr import Work
print(json.dumps([Work.GetConcurrencyLimit(), os.environ.get("PXR_WORK_THREAD_LIMIT")]))
"""


@pytest.mark.skipif(importlib.util.find_spec("pxr") is None, reason="needs the extra [usd]")
@pytest.mark.parametrize("wish", [None, "2"])
def test_usd_writes_without_threads_of_its_own_unless_told(wish):
    environment = {k: v for k, v in os.environ.items() if k != "PXR_WORK_THREAD_LIMIT"}
    if wish:
        environment["PXR_WORK_THREAD_LIMIT"] = wish
    done = subprocess.run(
        [sys.executable, "-c", USD], env=environment, capture_output=True, text=True, check=True, timeout=60
    )
    assert json.loads(done.stdout.splitlines()[-1]) == [int(wish or 1), wish]
    assert wish or not done.stderr
