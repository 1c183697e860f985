"""Docstrings of public names: each argument, the return value, and which calls are collective."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import pytest

import motes
from motes._values.field_texts import with_fields

MODULES = {"motes": motes} | {
    f"motes.{name}": getattr(motes, name) for name in motes.__all__ if inspect.ismodule(getattr(motes, name))
}
COLLECTIVE = {
    "World": "__enter__ __exit__ close digest frames open redraw render seek step",
    "System": "gather histogram surface tally total",
    "Export": "close write",
}
"""Calls that every rank must make; any other call may be made on a single rank."""
NOT_MADE = {"Balancer", "Shape", "History", "Tables"}
"""Classes that users do not construct: bases and protocols."""


def owned(kind: type) -> Iterator[tuple[str, Any]]:
    """Return the public members that the package defines in a class or its bases."""
    for name in dir(kind):
        found = inspect.getattr_static(kind, name)
        home = next(base for base in kind.__mro__ if name in vars(base))
        if (
            home.__module__.partition(".")[0] in ("motes", "motes_lab")
            and name[0] != "_"
            and (told(found) or is_read(found))
        ):
            yield name, found


def public() -> dict[str, Any]:
    """Return every public function, class, method and property by name; inherited members appear once."""
    found: dict[str, Any] = {}
    for prefix, module in MODULES.items():
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.isclass(thing) or inspect.isroutine(thing):
                found.setdefault(f"{prefix}.{name}", thing)
            if inspect.isclass(thing):
                for member, one in owned(thing):
                    found.setdefault(f"{prefix}.{name}.{member}", one)
    once = {id(told(thing) or thing): name for name, thing in reversed(found.items())}
    return {name: found[name] for name in once.values()}


def is_read(thing: Any) -> bool:
    """Return whether `thing` is a computed attribute."""
    return isinstance(thing, (property, cached_property))


def told(thing: Any) -> Any:
    """Return the function that holds the docstring, also for class methods; None if there is none."""
    if isinstance(thing, (classmethod, staticmethod)):
        return thing.__func__
    return thing if inspect.isroutine(thing) else None


def sections(docstring: str) -> dict[str, str]:
    """Split a docstring at its headings; the key of the text before them is ""."""
    parts = re.split(r"^(Args|Attributes|Fields|Returns|Yields|Raises):\n", docstring, flags=re.MULTILINE)
    return {"": parts[0]} | dict(zip(parts[1::2], parts[2::2], strict=True))


def described(text: str) -> list[str]:
    """Return the names that a section describes."""
    return re.findall(r"^    ([*\w]+):(?: |$)", text, re.MULTILINE)


def names_of(signature: inspect.Signature) -> list[str]:
    """Return the parameters that a caller passes, as `Args:` names them."""
    marks = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
    taken = signature.parameters.values()
    return [marks.get(one.kind, "") + one.name for one in taken if one.name not in ("self", "cls")]


def fields_of(kind: type) -> list[str]:
    """Return the fields that a class or its bases document, in the docstring or below each field."""
    found = []
    for base in kind.__mro__:
        text = with_fields(base, base.__doc__ or "") if dataclasses.is_dataclass(base) else base.__doc__
        whole = sections(inspect.cleandoc(text or ""))
        found += [one for part in ("Attributes", "Fields") for one in described(whole.get(part, ""))]
    return found


def faults_of_class(name: str, kind: type) -> list[str]:
    """Return what the docstrings of a class and its constructor lack."""
    if not inspect.getdoc(kind):
        return [f"{name}: no docstring"]
    if kind.__name__ in NOT_MADE or issubclass(kind, BaseException) and "__init__" not in vars(kind):
        return []
    made = inspect.signature(kind)
    given = described(sections(inspect.cleandoc(kind.__init__.__doc__ or "")).get("Args", ""))
    missing = [one for one in names_of(made) if one not in {*given, *fields_of(kind)}]
    return [f"{name}(...): {', '.join(missing)} not described"] if missing else []


def faults(name: str, thing: Any) -> list[str]:
    """Return what the docstring of a name lacks."""
    if inspect.isclass(thing):
        return faults_of_class(name, thing)
    if isinstance(thing, (property, cached_property)):
        return [] if inspect.getdoc(thing) else [f"{name}: no docstring"]
    function = inspect.unwrap(told(thing))
    text = inspect.cleandoc(function.__doc__ or "")
    if not text:
        return [f"{name}: no docstring"]
    found, taken = sections(text), inspect.signature(function)
    given = described(found.get("Args", ""))
    missing = [one for one in names_of(taken) if one not in given]
    strange = [one for one in given if one not in names_of(taken)]
    result = [f"{name}: {', '.join(missing)} not described"] if missing else []
    result += [f"{name}: takes no {', '.join(strange)}"] if strange else []
    silent = taken.return_annotation in (None, "None", "NoReturn", inspect.Signature.empty)
    if not silent and not text.startswith("Return ") and not {"Returns", "Yields"} & found.keys():
        result.append(f"{name}: what it returns is not described")
    return result


PUBLIC = public()


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_docstrings_say_what_goes_in_and_what_comes_out(name: str):
    assert faults(name, PUBLIC[name]) == []


def test_docstrings_tell_no_private_fields():
    kinds = {name: kind for name, kind in PUBLIC.items() if inspect.isclass(kind)}
    told_of = {name: [one for one in fields_of(kind) if one.startswith("_")] for name, kind in kinds.items()}
    assert {name: private for name, private in told_of.items() if private} == {}


@pytest.mark.parametrize("kind", COLLECTIVE)
def test_collective_calls_say_so(kind: str):
    members = {name: inspect.getattr_static(getattr(motes, kind), name) for name in dir(getattr(motes, kind))}
    said = {
        name
        for name, thing in members.items()
        if told(thing) and name[:2] in ("__", name[:2].lstrip("_")) and says_collective(told(thing))
    }
    assert said == set(COLLECTIVE[kind].split())


def says_collective(function: Any) -> bool:
    """Return whether a docstring has the word that marks calls which every rank must make."""
    return bool(re.search(r"\bCollective\b", function.__doc__ or ""))
