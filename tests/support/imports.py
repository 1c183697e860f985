"""Imports between a package's modules: at the start, later in functions, or only for type checkers."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import motes

__all__ = ["LABORATORY", "PACKAGE", "modules", "reached", "room_of", "rooms"]

PACKAGE = Path(motes.__file__).parent
LABORATORY = PACKAGE.with_name("motes_lab")
START, LATER, TYPES = "start", "later", "types"


def modules(*kinds: str, package: Path = PACKAGE) -> dict[str, set[str]]:
    """Map each module to those that it imports in one of these ways; the package itself is excluded."""
    graph = {}
    for path in package.rglob("*.py"):
        parts = path.relative_to(package).with_suffix("").parts
        name = ".".join(part for part in parts if part != "__init__")
        if name:
            found = _imports(path, package)
            graph[name] = {other for other, kind in found if kind in (kinds or (START,))} - {""}
    return graph


def rooms(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Map each room to the others whose modules its own import."""
    found: dict[str, set[str]] = {room_of(name): set() for name in graph}
    for name, others in graph.items():
        found[room_of(name)] |= {room_of(one) for one in others if one in graph} - {room_of(name)}
    return found


def room_of(name: str) -> str:
    """Return the room of a module: its folder, or the module itself if it is in no folder."""
    if (PACKAGE.joinpath(*name.split(".")) / "__init__.py").is_file():
        return name
    return name.rpartition(".")[0] or name


def reached(graph: dict[str, set[str]], start: str) -> set[str]:
    """Return all modules that importing one of them loads, including parent packages."""
    seen, waiting = set(), [start]
    while waiting:
        for name in graph.get(waiting.pop(), ()):
            parts = name.split(".")
            for one in (".".join(parts[: i + 1]) for i in range(len(parts))):
                if one not in seen:
                    seen.add(one)
                    waiting.append(one)
    return seen


def _imports(path: Path, root: Path) -> Iterator[tuple[str, str]]:
    package = path.relative_to(root).parts[:-1]
    for node, kind in _nodes(ast.parse(path.read_text()), START):
        if not isinstance(node, ast.ImportFrom) or node.level == 0:
            continue
        base = (*package[: len(package) - node.level + 1], *(node.module or "").split("."))
        base = tuple(part for part in base if part)
        for alias in node.names:
            whole = root.joinpath(*base, alias.name)
            is_module = whole.is_dir() or whole.with_suffix(".py").is_file() or alias.name == "_core"
            yield ".".join((*base, alias.name) if is_module else base), kind


def _nodes(tree: ast.AST, kind: str) -> Iterator[tuple[ast.AST, str]]:
    for node in ast.iter_child_nodes(tree):
        inner = kind
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and kind == START:
            inner = LATER
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            inner = TYPES
        yield node, inner
        yield from _nodes(node, inner)
