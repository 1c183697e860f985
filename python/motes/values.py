"""Values: objects that never change once made; those with equal fields are equal."""

from __future__ import annotations

import ast
import functools
import inspect
import itertools
import math
import textwrap
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from typing import Any, ClassVar, NoReturn, TypeVar, dataclass_transform

from .errors import ArgumentError, NotAssignable, near

__all__ = ["Moving", "Settings", "Value", "at", "says_near_names", "shown", "times_of", "value"]

T = TypeVar("T")
Function = TypeVar("Function", bound=Callable[..., Any])


class Moving:
    """Base of what stands for a number or a vector that depends on time: `motes.Curve`.

    No abstract base class: each field of each value is asked whether it is one, which takes five times as
    long of those.
    """

    times: tuple[float, ...]
    """Where it has its extreme values."""

    @abstractmethod
    def __call__(self, time: float) -> Any:
        """Return the number or vector at a time, in seconds."""


class Value:
    """Base of values: they are immutable, compare and hash by their fields, can be copied and pickled.

    `repr` shows the call that makes an equal value. Subclasses are decorated by `value`.
    """

    _may_move: ClassVar[bool] = False
    """Whether curves may stand in its fields."""
    moves = False
    """Whether a curve stands in a field."""

    def at_time(self: T, time: float) -> T:
        """Return the value as it is at a time, in seconds: with the curves' values in place of curves."""
        if not self.moves:  # type: ignore[attr-defined]
            return self
        items: dict[str, Any] = self._items()  # type: ignore[attr-defined]
        return type(self)(**{name: at(field, time) for name, field in items.items()})

    def _check_moving(self, given: Sequence[Any]) -> None:
        """Check all that the value will be, whose fields are `given`."""
        for time in times_of(given):
            type(self)(**{name: at(field, time) for name, field in self._items().items()})
        self.__dict__["moves"] = True

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> NoReturn:
        """Refuse NumPy's arithmetic, which would take any object for a true constant."""
        self.__array_function__(ufunc, (), inputs, keywords)

    def __array_function__(self, function: Any, types: Any, args: Any, keywords: Any) -> NoReturn:
        """Refuse NumPy's functions, for the same reason."""
        kind = type(self).__name__
        allowed = f"a function of arrays; a {kind} is none, and can only be given to motes"
        raise ArgumentError("function", f"numpy.{function.__name__}", allowed)

    def _items(self) -> dict[str, Any]:
        """Return the fields as they are now, by name."""
        state = self.__dict__
        return {field.name: state[field.name] for field in fields(self)}  # type: ignore[arg-type]

    def _key(self) -> tuple[Any, ...]:
        """Return what is compared and hashed."""
        return tuple(self._items().values())

    def __eq__(self, other: object) -> bool:
        """Equal type and fields."""
        if type(self) is not type(other):
            return NotImplemented
        assert isinstance(other, Value)
        return self._key() == other._key()

    def __hash__(self) -> int:
        """Hash of type and fields."""
        return hash((type(self), self._key()))

    def __copy__(self: T) -> T:
        """Return the value itself: it never changes."""
        return self

    def __deepcopy__(self: T, _: object) -> T:
        """Return the value itself: it never changes."""
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the fields: unpickling checks them again."""
        return _made, (type(self), self._items())

    def __repr__(self) -> str:
        """Show the call that makes this value, without the arguments that have their defaults."""
        defaults = {field.name: field.default for field in fields(self)}  # type: ignore[arg-type]
        items = self._items().items()
        arguments = [f"{name}={shown(v)}" for name, v in items if not _same(v, defaults[name])]
        return f"{type(self).__name__}({', '.join(arguments)})"

    def __setattr__(self, name: str, _: object) -> NoReturn:
        """Refuse: values do not change."""
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        kind = type(self).__name__
        if name in names:
            raise NotAssignable(
                f"{kind}.{name} cannot be assigned: values do not change; make a new {kind}, "
                f"or dataclasses.replace(it, {name}=...)"
            )
        raise NotAssignable(f"{kind} has no attribute {name!r}{near(name, names)}")

    def __delattr__(self, name: str) -> NoReturn:
        """Refuse: values do not change."""
        raise NotAssignable(f"{type(self).__name__}.{name} cannot be deleted: values do not change")


def at(given: Any, time: float) -> Any:
    """Return what a field is at a time: a curve's value then, or the field itself where it does not move."""
    if isinstance(given, Moving):
        return given(time)
    return given.at_time(time) if isinstance(given, Value) else given


def times_of(given: Iterable[Any]) -> list[float]:
    """Return the times at which some of the values begin to move another way, in seconds."""
    return sorted({time for one in given if isinstance(one, Moving) for time in one.times})


class FieldTexts:
    """A class's docstring with the texts that stand below its fields, for `help`.

    They are read from the source when somebody asks. `shown`: the site shows them field by field.
    """

    shown = True

    def __init__(self, text: str) -> None:
        """Take the docstring itself."""
        self._text = text

    def __get__(self, _: object, kind: type) -> str:
        """Return the whole text."""
        if not self.shown:
            return self._text
        try:
            (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
        except (OSError, TypeError, SyntaxError, ValueError):  # no source here
            return self._text
        lines = []
        for field, below in itertools.pairwise(getattr(tree, "body", ())):
            text = _text_of(below)
            if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and text:
                lines.append(f"    {field.target.id}: {textwrap.indent(text, ' ' * 8).strip()}")
        fields_ = "\n".join(lines)
        return f"{inspect.cleandoc(self._text)}\n\nFields:\n{fields_}\n" if lines else self._text


def _text_of(statement: ast.stmt) -> str:
    value = statement.value if isinstance(statement, ast.Expr) else None
    return (
        inspect.cleandoc(value.value)
        if isinstance(value, ast.Constant) and isinstance(value.value, str)
        else ""
    )


class Settings:
    """Base of objects with attributes that may change: each is checked when assigned; there are no others."""

    _checks: ClassVar[Mapping[str, Callable[[str, Any], Any]]]
    """By name: the check that takes name and value, and returns the value to keep."""
    _may_move: ClassVar[frozenset[str]] = frozenset()
    """The names of those that may be curves."""

    def __init_subclass__(cls) -> None:
        """Let `help` show the texts of the attributes."""
        cls.__doc__ = FieldTexts(cls.__doc__ or "")  # type: ignore[assignment]

    def __setattr__(self, name: str, given: Any) -> None:
        """Check and keep; names of the package itself begin with an underscore."""
        if name.startswith("_"):
            self.__dict__[name] = given
            return
        check = self._checks.get(name)
        if check is None:
            kind = type(self).__name__
            if name in self.__dict__:
                raise NotAssignable(f"{kind}.{name} is fixed when the {kind} is made")
            raise NotAssignable(f"{kind} has no attribute {name!r}{near(name, self._checks)}")
        if isinstance(given, Moving) and name in self._may_move:
            for time in given.times:
                check(name, given(time))
            self.__dict__[name] = given
        else:
            self.__dict__[name] = check(name, given)


@dataclass_transform(frozen_default=True, eq_default=False)
def value(*, init: bool = True, kw_only: bool = False) -> Callable[[type[T]], type[T]]:
    """Make a subclass of `Value` a dataclass; `init=False` where it has a constructor of its own."""

    def made(kind: type[T]) -> type[T]:
        decorated = dataclass(init=init, kw_only=kw_only, frozen=True, eq=False, repr=False)(kind)
        # A frozen dataclass has its own refusals; these say what to do instead.
        decorated.__setattr__ = Value.__setattr__  # type: ignore[method-assign, assignment]
        decorated.__delattr__ = Value.__delattr__  # type: ignore[method-assign, assignment]
        made_of_fields = _constructor(decorated, kw_only) if init else says_near_names(decorated.__init__)
        decorated.__init__ = made_of_fields  # type: ignore[method-assign]
        decorated.__doc__ = FieldTexts(decorated.__doc__ or "")  # type: ignore[assignment]
        return decorated

    return made


def _constructor(kind: Any, kw_only: bool) -> Any:
    """Return a constructor for a dataclass that takes half the time: scripts make values by the hundred."""
    names = [field.name for field in fields(kind)]
    defaults = {f"_{f.name}": f.default for f in fields(kind)}  # MISSING where there is none
    parameters = ", ".join(f"{name}=_{name}" for name in names)
    required = [f.name for f in fields(kind) if f.default is MISSING]
    lacks = " or ".join(["_unknown", *(f"{name} is _missing" for name in required)])
    lines = [
        f"def __init__(self, {'*, ' if kw_only else ''}{parameters}, **_unknown):",
        f"    if {lacks}: _refuse(self, _unknown, [{', '.join(required)}])",
        "    _state = self.__dict__",
        *(f"    _state[{name!r}] = {name}" for name in names),
        *_checks_of(kind, names),
    ]
    scope = {**defaults, "_missing": MISSING, "_refuse": _refuse, "_Moving": Moving}
    exec("\n".join(lines), scope)  # of names of fields alone
    made: Any = scope["__init__"]
    made.__signature__ = inspect.signature(kind.__init__)
    made.__doc__ = kind.__init__.__doc__
    made.__qualname__ = f"{kind.__qualname__}.__init__"
    made.__module__ = kind.__module__
    return made


def _checks_of(kind: Any, names: Sequence[str]) -> list[str]:
    """Return the constructor's last lines: what checks the fields."""
    if not kind._may_move or not names:
        return ["    self.__post_init__()"]
    return [
        f"    if {' or '.join(f'isinstance({name}, _Moving)' for name in names)}:",
        f"        self._check_moving(({', '.join(names)},))",
        "    else:",
        "        self.__post_init__()",
    ]


def _refuse(self: Any, unknown: Mapping[str, object], given: list[object]) -> NoReturn:
    names = [field.name for field in fields(self)]
    call = f"{type(self).__name__}.__init__()"
    for name in unknown:
        raise TypeError(f"{call} got an unexpected keyword argument {name!r}{near(name, names)}")
    required = [field.name for field in fields(self) if field.default is MISSING]
    missing = [repr(name) for name, one in zip(required, given, strict=True) if one is MISSING]
    raise TypeError(f"{call} missing {len(missing)} required arguments: {', '.join(missing)}")


def says_near_names(function: Function) -> Function:
    """Let a function that gets an unknown keyword argument say which known one is near."""
    code = function.__code__
    known = code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]

    @functools.wraps(function)
    def checked(*args: Any, **keywords: Any) -> Any:
        try:
            return function(*args, **keywords)
        except TypeError as error:
            for name in keywords:
                if name not in known and f"unexpected keyword argument '{name}'" in str(error):
                    error.args = (str(error).partition(". Did you mean")[0] + near(name, known),)
            raise

    setattr(checked, "__kwdefaults__", function.__kwdefaults__)  # noqa: B010 (for readers; the call applies them)
    return checked  # type: ignore[return-value]


def shown(value: object) -> str:
    """Show a field so that Python reads it back without any import."""
    if isinstance(value, float) and not math.isfinite(value):
        return f"float({str(value)!r})"
    if hasattr(value, "__array_interface__") and getattr(value, "ndim", 0) > 0:
        return f"<array of shape {getattr(value, 'shape', ())}>"
    if isinstance(value, tuple):
        return f"({', '.join(map(shown, value))}{',' if len(value) == 1 else ''})"
    return repr(value)


def _same(value: object, default: object) -> bool:
    plain = isinstance(value, (int, float, str, tuple, type(None)))
    return value is default or (plain and type(default) is not object and value == default)


def _made(kind: Callable[..., T], arguments: dict[str, Any]) -> T:
    return kind(**arguments)
