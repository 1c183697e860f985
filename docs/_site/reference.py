"""The reference of the Python package: every public name, with its docstring."""

from __future__ import annotations

import inspect
import sys
from types import ModuleType
from typing import Any

from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.errors import ExtensionError
from sphinx.pycode import ModuleAnalyzer

import motes
from _site.docstrings import markup
from _site.pages import DOCS, Pages

FOLDER = DOCS / "reference" / "python"
INDEX = """
The Python package
==================

All public names. Start with `World` and `System`.
"""
BASES = "ABC, Action, BaseException, Mapping, NamedTuple, Sequence, Shape, Value, object, tuple"
"""Classes whose methods are not repeated in the classes that inherit them."""


def modules() -> dict[str, ModuleType]:
    """Return the public modules by name, the package itself first."""
    found = {"motes": motes}
    for name in motes.__all__:
        if inspect.ismodule(getattr(motes, name)):
            found[f"motes.{name}"] = getattr(motes, name)
    return found


def names(module: ModuleType) -> list[str]:
    """Return the public names of a module that are not modules."""
    return sorted(name for name in module.__all__ if not inspect.ismodule(getattr(module, name)))


def elsewhere(name: str) -> str:
    """Return the public module that describes a name of the package, "" for the package itself."""
    thing = getattr(motes, name)
    described = (full for full, module in modules().items() if full != "motes" and name in names(module))
    return next((full for full in described if getattr(modules()[full], name) is thing), "")


def kind_of(thing: Any) -> str:
    """Return the directive's name for a class, an exception, a function or a constant."""
    if inspect.isclass(thing):
        return "exception" if issubclass(thing, BaseException) else "class"
    return "function" if inspect.isroutine(thing) else "data"


def entry(full: str, thing: Any) -> str:
    """Return the directive that describes a name."""
    kind, options = kind_of(thing), []
    if inspect.isclass(thing):
        options = [":members:", f":inherited-members: {BASES}"]
    elif kind == "data":
        module, _, name = full.rpartition(".")
        return f".. py:data:: {name}\n   :module: {module}\n\n   {said(module, name, thing)}\n"
    return "\n".join([f".. auto{kind}:: {full}", *(f"   {option}" for option in options), ""])


def said(module: str, name: str, thing: Any) -> str:
    """Return the docstring below a constant, in whichever module of the package defines it."""
    own = sys.modules[module].__name__  # of a room of the laboratory, its name there
    for full in sorted(full for full in sys.modules if full.startswith(own)):
        if getattr(sys.modules[full], name, None) is thing:
            analyzer = ModuleAnalyzer.for_module(full)
            analyzer.analyze()
            if ("", name) in analyzer.attr_docs:
                return " ".join(markup(analyzer.attr_docs["", name])).strip()
    raise ExtensionError(f"{module}.{name} has no docstring")


def alias(full: str, module: str) -> str:
    """Return the entry of a name that another module describes."""
    name = full.rpartition(".")[2]
    kind = kind_of(getattr(motes, name))
    return f".. py:{kind}:: {name}\n   :module: motes\n\n   The same as :py:obj:`{module}.{name}`.\n"


def headed(title: str, *texts: str) -> str:
    """Return a page with a title."""
    return "\n".join([title, "=" * len(title), "", *texts])


def contents(*pages: str) -> str:
    """Return a table of contents."""
    return "\n".join([".. toctree::", "   :maxdepth: 1", "", *(f"   {page}" for page in pages), ""])


def make() -> Pages:
    """Return all pages."""
    pages = Pages(FOLDER)
    own = [name for name in names(motes) if not elsewhere(name)]
    alone = [name for name in own if inspect.isclass(getattr(motes, name))]
    for name in alone:
        pages.add(f"{name}.rst", headed(name, entry(f"motes.{name}", getattr(motes, name))))
    rest = [entry(f"motes.{name}", getattr(motes, name)) for name in own if name not in alone]
    rest += [alias(f"motes.{name}", elsewhere(name)) for name in names(motes) if elsewhere(name)]
    pages.add("motes.rst", headed("motes", ".. automodule:: motes\n", contents(*alone), *rest))
    others = [full for full in modules() if full != "motes"]
    for full in others:
        entries = [entry(f"{full}.{name}", getattr(modules()[full], name)) for name in names(modules()[full])]
        pages.add(f"{full}.rst", headed(full, f".. automodule:: {full}\n", *entries))
    pages.add("index.rst", "\n".join([INDEX.strip(), "", contents("motes", *others)]))
    return pages


def prefer(app: Sphinx, env: BuildEnvironment) -> None:
    """Let references by class name lead to the page that describes the class."""
    known = env.domains.python_domain.objects
    for name in names(motes):
        if elsewhere(name):
            known[f"motes.{name}"] = known[f"motes.{name}"]._replace(aliased=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the handlers."""
    app.connect("builder-inited", lambda app: make().write())
    app.connect("env-updated", prefer)
    return {"parallel_read_safe": True}
