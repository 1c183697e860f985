"""The laboratory's rooms by their names in `motes`, in import statements too: each is one module."""

from __future__ import annotations

import importlib
import pickle
import subprocess
import sys

import motes.cluster.paper.tables as tables
import pytest

import motes
from motes.cluster import Cluster


@pytest.mark.parametrize("room", ["arena", "bench", "cluster", "course", "workloads"])
def test_a_room_has_two_names(room: str):
    own = importlib.import_module(f"motes_lab.{room}")
    assert importlib.import_module(f"motes.{room}") is own
    assert getattr(motes, room) is own
    assert own.__name__ == own.__spec__.name == f"motes_lab.{room}"


def test_modules_in_a_room_have_two_names():
    assert tables is sys.modules["motes_lab.cluster.paper.tables"]
    assert motes.cluster.paper.tables is tables
    assert Cluster is importlib.import_module("motes_lab.cluster.machines").Cluster
    assert pickle.loads(pickle.dumps(Cluster)) is Cluster


@pytest.mark.parametrize("first", ["motes", "motes_lab"])
def test_either_name_may_be_the_first(first: str):
    second = {"motes": "motes_lab", "motes_lab": "motes"}[first]
    code = f"from {first}.workloads.pic import Pic\nimport {second}.workloads.pic as other\n"
    subprocess.run([sys.executable, "-c", code + "assert other.Pic is Pic"], check=True, timeout=60)


def test_a_room_that_is_not_there_is_not_found():
    with pytest.raises(ModuleNotFoundError, match=r"'motes_lab\.cluster\.nothing'"):
        importlib.import_module("motes.cluster.nothing")
    with pytest.raises(ModuleNotFoundError, match=r"'motes\.clusters'"):
        importlib.import_module("motes.clusters")
