"""Balancers from command-line text: `PrefixCuts`, `Pairwise(threshold=0.05)`, `mine.py:Mine`."""

from __future__ import annotations

import ast
import importlib.util
import inspect
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from motes import balance
from motes.balance import Balancer
from motes.errors import ArgumentError, MotesError

__all__ = ["FIELD", "player"]

FIELD = ("Static", "Pairwise", "Pairwise(threshold=0.05)", *balance.BALANCERS[2:])
"""The balancers that play by default."""


def player(text: str, powers: Sequence[float] = (), move_cost: float | None = None) -> Balancer:
    """Make a balancer from its text.

    Args:
        text: the name of a balancer in `motes.balance`, optionally with keyword arguments in Python syntax;
            the beginning of its name in lower case; or `file.py:Name`, where Name is a balancer, or a
            balancer class that requires no arguments but those below.
        powers: the machines' powers, for `Proportional` if `text` gives none, and for classes of a file with
            an argument of this name; empty: unknown.
        move_cost: cost of moving a particle, in units of its actions' time per frame; for `CostAware` if
            `text` gives none, and for classes of a file with an argument of this name; None: unknown.

    Raises:
        ArgumentError: if `text` does not name a balancer.
        MotesError: if the file does not exist.
    """
    path, _, name = text.rpartition(":")
    if path.endswith(".py"):
        return _of_file(Path(path), name, {"powers": list(powers) or None, "move_cost": move_cost})
    if text.isalpha() and text.islower():
        return balance.by_name(text)
    kinds = {name: getattr(balance, name) for name in balance.BALANCERS}
    kind, options = _call(text)
    if kind not in kinds:
        raise ArgumentError("balancer", text, f"{', '.join(kinds)} or file.py:Name", known=kinds)
    if kind == "Proportional" and len(powers):
        options.setdefault("powers", list(powers))
    if kind == "CostAware" and move_cost is not None:
        options.setdefault("move_cost", move_cost)
    chosen: Balancer = kinds[kind](**options)
    return chosen


def _call(text: str) -> tuple[str, dict[str, Any]]:
    try:
        tree = ast.parse(text.strip(), mode="eval").body
        if isinstance(tree, ast.Name):
            return tree.id, {}
        if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and not tree.args:
            named = {str(one.arg): ast.literal_eval(one.value) for one in tree.keywords}
            return tree.func.id, named
    except (SyntaxError, ValueError):
        pass
    raise ArgumentError("balancer", text, "Name, Name(option=value) or file.py:Name")


def _of_file(path: Path, name: str, known: dict[str, Any]) -> Balancer:
    """Run a file and return its balancer of this name, made with what is known and it asks for."""
    if not path.is_file():
        raise MotesError(f"balancer file {path} does not exist")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules.setdefault(path.stem, module)  # dataclasses and pickles look there
    spec.loader.exec_module(module)
    balancer = getattr(module, name, None)
    if isinstance(balancer, type) and issubclass(balancer, Balancer):
        parameters = inspect.signature(balancer).parameters
        balancer = balancer(
            **{key: one for key, one in known.items() if key in parameters and one is not None}
        )
    if not isinstance(balancer, Balancer):
        own = [
            key
            for key, value in vars(module).items()
            if isinstance(value, type) and issubclass(value, Balancer)
        ]
        raise ArgumentError("balancer", f"{path}:{name}", f"a subclass of Balancer in {path}", known=own)
    return balancer
