"""Values: objects that never change once made; those with equal fields are equal."""

from __future__ import annotations

import functools
import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, TypeVar, dataclass_transform

from ..errors import ArgumentError, NotAssignableError, near

__all__ = [
    "Moving",
    "Settings",
    "Value",
    "at",
    "items_of",
    "key_of",
    "moves",
    "says_near_names",
    "shown",
    "times_of",
    "value",
]

if TYPE_CHECKING:
    from dataclasses import Field
    from inspect import Signature

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


class _Late:
    """An attribute of a class that is made each time somebody asks for it: runs never do."""

    def __init__(self, make: Callable[[type], Any]) -> None:
        self.make = make

    def __get__(self, _: object, kind: type) -> Any:
        return self.make(kind)


def _decorated(kind: type) -> Any:
    """Return the class itself, or the nearest base, that `value` has decorated."""
    for base in kind.__mro__:
        if "_fields" in vars(base):
            return base
    raise TypeError(f"{kind.__name__} is only the base of values")


def _fields_of(kind: type) -> dict[str, Field[Any]]:
    """Make a class a dataclass; return its fields."""
    from dataclasses import dataclass

    made = _decorated(kind)
    dataclass(init=False, repr=False, eq=False, match_args=False, kw_only=not made.__match_args__)(made)
    found: dict[str, Field[Any]] = made.__dataclass_fields__
    return found


def _signature_of(kind: Any) -> Signature:
    """Return the signature of a class without a constructor of its own."""
    from inspect import Parameter, Signature

    if kind.__init__ is not Value.__init__:
        raise AttributeError("__signature__")
    how = Parameter.POSITIONAL_OR_KEYWORD if kind.__match_args__ else Parameter.KEYWORD_ONLY
    parameters = [
        Parameter(name, how, default=kind._defaults.get(name, Parameter.empty), annotation=text)
        for name, text in kind._fields.items()
    ]
    return Signature(parameters, return_annotation=None)


class Value:
    """Base of values: they are immutable, compare and hash by their fields, can be copied and pickled.

    `repr` shows the call that makes an equal value. Subclasses are decorated by `value`, and become
    dataclasses when `dataclasses` first looks at them: constructors that `dataclass` writes would take 34 ms
    of each start, for 49 classes of which a run uses ten, and make a value hardly faster.
    """

    __signature__ = _Late(_signature_of)
    _fields: ClassVar[dict[str, str]]
    """The fields' types as text, by name."""
    _defaults: ClassVar[dict[str, Any]] = {}
    """Of those that have one."""
    __match_args__: ClassVar[tuple[str, ...]] = ()
    """The fields that may be given by place: all or none."""
    _may_move: ClassVar[bool] = False
    """Whether curves may stand in its fields."""
    _moves = False
    """Whether a curve stands in a field."""

    def __init__(self, *by_place: Any, **given: Any) -> None:
        """Take the fields."""
        kind = type(self)
        if by_place:
            given = self._named(by_place, given)
        state = self.__dict__
        state.update(kind._defaults)
        state.update(given)
        if state.keys() != _decorated(kind)._fields.keys():
            self._refuse(given)
        if kind._may_move:
            for one in given.values():
                if isinstance(one, Moving):
                    self._check_moving()
                    return
        self.__post_init__()

    def _named(self, by_place: tuple[Any, ...], given: dict[str, Any]) -> dict[str, Any]:
        """Return all arguments by name. Raises TypeError for too many, as Python does."""
        call, names = f"{type(self).__name__}.__init__()", self.__match_args__
        if len(by_place) > len(names):
            counted = f"{1 + len(names)} positional argument{'s' if names else ''}"  # self is one of them
            raise TypeError(f"{call} takes {counted} but {1 + len(by_place)} were given")
        placed = dict(zip(names, by_place, strict=False))
        for name in placed.keys() & given.keys():
            raise TypeError(f"{call} got multiple values for argument {name!r}")
        return placed | given

    def __post_init__(self) -> None:
        """Check the fields."""

    def _at_time(self: T, time: float) -> T:
        """Return the value as it is at a time, in seconds: with the curves' values in place of curves."""
        if not self._moves:  # type: ignore[attr-defined]
            return self
        items: dict[str, Any] = self._items()  # type: ignore[attr-defined]
        return type(self)(**{name: at(field, time) for name, field in items.items()})

    def _refuse(self, given: Mapping[str, Any]) -> NoReturn:
        """Raise TypeError for arguments that do not fit, as Python does, but with the near name."""
        call = f"{_decorated(type(self)).__name__}.__init__()"
        for name in given:
            if name not in self._fields:
                hint = near(name, self._fields)
                raise TypeError(f"{call} got an unexpected keyword argument {name!r}{hint}")
        missing = [repr(name) for name in self._fields if name not in self.__dict__]
        counted = f"{len(missing)} required argument{'s' if len(missing) > 1 else ''}"
        raise TypeError(f"{call} missing {counted}: {', '.join(missing)}")

    def _check_moving(self) -> None:
        """Check all that the value will be."""
        items = self._items()
        for time in times_of(items.values()):
            type(self)(**{name: at(field, time) for name, field in items.items()})
        self.__dict__["_moves"] = True

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
        return {name: state[name] for name in self._fields}

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

    def __replace__(self: T, **changes: Any) -> T:
        """Make another value for `copy.replace`."""
        return type(self)(**(self._items() | changes))  # type: ignore[attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the fields: unpickling checks them again."""
        return _made, (type(self), self._items())

    def __repr__(self) -> str:
        """Show the call that makes this value, without the arguments that have their defaults."""
        given = {name: one for name, one in self._items().items() if not self._is_default(name, one)}
        arguments = [f"{name}={shown(one)}" for name, one in given.items()]
        return f"{type(self).__name__}({', '.join(arguments)})"

    def _is_default(self, name: str, given: object) -> bool:
        default = self._defaults.get(name, self)
        plain = isinstance(given, (int, float, str, tuple, type(None)))
        return given is default or (plain and given == default)

    def __setattr__(self, name: str, _: object) -> NoReturn:
        """Refuse: values do not change."""
        kind = type(self).__name__
        if name in self._fields:
            raise NotAssignableError(
                f"{kind}.{name} cannot be assigned: values do not change; make a new {kind}, "
                f"or dataclasses.replace(it, {name}=...)"
            )
        raise NotAssignableError(f"{kind} has no attribute {name!r}{near(name, self._fields)}")

    def __delattr__(self, name: str) -> NoReturn:
        """Refuse: values do not change."""
        raise NotAssignableError(f"{type(self).__name__}.{name} cannot be deleted: values do not change")


def at(given: Any, time: float) -> Any:
    """Return what a field is at a time: a curve's value then, or the field itself where it does not move."""
    if isinstance(given, Moving):
        return given(time)
    return given._at_time(time) if isinstance(given, Value) else given


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
        from .field_texts import with_fields

        return with_fields(kind, self._text)


def items_of(value: Value) -> dict[str, Any]:
    """Return a value's fields by name."""
    return value._items()


def key_of(value: Value) -> tuple[Any, ...]:
    """Return what is compared and hashed of a value."""
    return value._key()


def moves(value: Value) -> bool:
    """Tell whether a curve stands in a field of a value."""
    return value._moves


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
                raise NotAssignableError(f"{kind}.{name} is fixed when the {kind} is made")
            raise NotAssignableError(f"{kind} has no attribute {name!r}{near(name, self._checks)}")
        if isinstance(given, Moving) and name in self._may_move:
            for time in given.times:
                check(name, given(time))
            self.__dict__[name] = given
        else:
            self.__dict__[name] = check(name, given)


@dataclass_transform(frozen_default=True, eq_default=False)
def value(*, init: bool = True, kw_only: bool = False) -> Callable[[type[T]], type[T]]:
    """Give a subclass of `Value` its fields; `init=False` where it has a constructor of its own."""

    def made(kind: Any) -> type[T]:
        own = {name: text for name, text in kind.__annotations__.items() if not text.startswith("ClassVar")}
        kind._fields = getattr(kind, "_fields", {}) | own
        kind._defaults = kind._defaults | {name: vars(kind)[name] for name in own if name in vars(kind)}
        kind.__match_args__ = () if kw_only else tuple(kind._fields)  # type: ignore[misc]
        kind.__dataclass_fields__ = _Late(_fields_of)
        if not init:
            kind.__init__ = says_near_names(kind.__init__)
        kind.__doc__ = FieldTexts(kind.__doc__ or "")
        decorated: type[T] = kind
        return decorated

    return made


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


def _made(kind: Callable[..., T], arguments: dict[str, Any]) -> T:
    return kind(**arguments)
