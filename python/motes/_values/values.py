"""Values: immutable objects that are equal if their fields are."""

from __future__ import annotations

import functools
import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, TypeVar, dataclass_transform

from ..errors import ArgumentError, NotAssignableError, near

__all__ = [
    "Moving",
    "Settings",
    "Value",
    "at",
    "items_of",
    "joined",
    "key_of",
    "moves",
    "says_near_names",
    "shown",
    "text_of",
    "times_of",
    "value",
]

if TYPE_CHECKING:
    from dataclasses import Field
    from inspect import Signature

T = TypeVar("T")
Function = TypeVar("Function", bound=Callable[..., Any])


class Moving:
    """Base of numbers and vectors that depend on time: `motes.Curve`.

    Not an `abc.ABC`: each field of each value is tested by `isinstance`, which takes five times as long for
    an ABC.
    """

    times: tuple[float, ...]
    """The times of its keys, s, at which its values are checked."""

    @abstractmethod
    def __call__(self, time: float) -> Any:
        """Return the number or vector at a time, in seconds."""

    @abstractmethod
    def in_vector(self, components: Sequence[Any]) -> Moving:
        """Return the vector of these components, of which this is one."""


class _Late:
    """A class attribute that is computed on each access; runs never access it."""

    def __init__(self, make: Callable[[type], Any]) -> None:
        self.make = make

    def __get__(self, _: object, kind: type) -> Any:
        return self.make(kind)


def _decorated(kind: type) -> Any:
    """Return the class itself, or the nearest base, that `value` has decorated."""
    for base in kind.__mro__:
        if "_fields" in vars(base):
            return base
    raise TypeError(f"{kind.__name__} is only a base class of values")


def _fields_of(kind: type) -> dict[str, Field[Any]]:
    """Turn a class into a dataclass and return its fields."""
    from dataclasses import dataclass

    decorated = _decorated(kind)
    by_name = decorated.__annotations__.keys().isdisjoint(decorated.__match_args__)
    dataclass(init=False, repr=False, eq=False, match_args=False, kw_only=by_name)(decorated)
    fields: dict[str, Field[Any]] = decorated.__dataclass_fields__
    return fields


def _signature_of(kind: Any) -> Signature:
    """Return the signature of a class that inherits `Value.__init__`; raise AttributeError for others."""
    from inspect import Parameter, Signature

    if kind.__init__ is not Value.__init__:
        raise AttributeError("__signature__")
    by_place = kind.__match_args__
    kinds = dict.fromkeys(by_place, Parameter.POSITIONAL_OR_KEYWORD)
    kinds |= {name: Parameter.KEYWORD_ONLY for name in kind._fields if name not in by_place}
    parameters = [
        Parameter(name, how, default=kind._defaults.get(name, Parameter.empty), annotation=kind._fields[name])
        for name, how in kinds.items()
    ]
    return Signature(parameters, return_annotation=None)


class Value:
    """Base of values: they are immutable, compare and hash by their fields, can be copied and pickled.

    `repr` shows a call that creates an equal value. Subclasses are decorated with `value` and become
    dataclasses when `dataclasses` first inspects them.
    """

    # Home-made, because each start of a rank defines all of these classes and uses about ten. Milliseconds of
    # processor time to define the 75 of them, and for the import, with Python 3.11: dataclasses 23 + 5, attrs
    # 23 + 16, msgspec 1 + 10, this module 1.

    __signature__ = _Late(_signature_of)
    _fields: ClassVar[dict[str, str]]
    """The fields' types as text, by name."""
    _defaults: ClassVar[dict[str, Any]] = {}
    """The fields' default values, by name, for fields that have one."""
    __match_args__: ClassVar[tuple[str, ...]] = ()
    """The fields that may be passed positionally."""
    _may_move: ClassVar[bool] = False
    """Whether fields may be curves."""
    _moves = False
    """Whether a field is a curve."""

    def __init__(self, *by_place: Any, **given: Any) -> None:
        """Set and check the fields."""
        kind = type(self)
        if by_place:
            given = self._named(by_place, given)
        state = self.__dict__
        state.update(kind._defaults)
        state.update(given)
        if state.keys() != _decorated(kind)._fields.keys():
            self._refuse(given)
        if kind._may_move:
            moving = False
            for name, one in given.items():
                if type(one) is tuple or type(one) is list:
                    state[name] = one = joined(one)
                moving |= isinstance(one, Moving)
            if moving:
                self._check_moving()
                return
        self.__post_init__()

    def _named(self, by_place: tuple[Any, ...], given: dict[str, Any]) -> dict[str, Any]:
        """Return all arguments by name. Raises TypeError for too many or duplicate ones, as Python does."""
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
        """Return the value with each curve replaced by the curve's value at `time`, in seconds."""
        if not self._moves:  # type: ignore[attr-defined]
            return self
        items: dict[str, Any] = self._items()  # type: ignore[attr-defined]
        return type(self)(**{name: at(field, time) for name, field in items.items()})

    def _refuse(self, given: Mapping[str, Any]) -> NoReturn:
        """Raise TypeError for unknown or missing arguments, as Python does, but suggest the closest name."""
        call = f"{_decorated(type(self)).__name__}.__init__()"
        for name in given:
            if name not in self._fields:
                hint = near(name, self._fields)
                raise TypeError(f"{call} got an unexpected keyword argument {name!r}{hint}")
        missing = [repr(name) for name in self._fields if name not in self.__dict__]
        counted = f"{len(missing)} required argument{'s' if len(missing) > 1 else ''}"
        raise TypeError(f"{call} missing {counted}: {', '.join(missing)}")

    def _check_moving(self) -> None:
        """Check the value at the times of all keys of its curves."""
        items = self._items()
        for time in times_of(items.values()):
            type(self)(**{name: at(field, time) for name, field in items.items()})
        self.__dict__["_moves"] = True

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> NoReturn:
        """Refuse NumPy's ufuncs, which would treat any object as a constant that is true."""
        self.__array_function__(ufunc, (), inputs, keywords)

    def __array_function__(self, function: Any, types: Any, args: Any, keywords: Any) -> NoReturn:
        """Refuse NumPy's functions, which would treat any object as a constant that is true."""
        kind = type(self).__name__
        allowed = f"a function of motes; NumPy cannot compute with a {kind}"
        raise ArgumentError("function", f"numpy.{function.__name__}", allowed)

    def _items(self) -> dict[str, Any]:
        """Return the fields by name."""
        state = self.__dict__
        return {name: state[name] for name in self._fields}

    def _key(self) -> tuple[Any, ...]:
        """Return the tuple by which values are compared and hashed."""
        return tuple(self._items().values())

    def __eq__(self, other: object) -> bool:
        """Return whether type and fields are equal."""
        if type(self) is not type(other):
            return NotImplemented
        assert isinstance(other, Value)
        return self._key() == other._key()

    def __hash__(self) -> int:
        """Hash type and fields."""
        return hash((type(self), self._key()))

    def __copy__(self: T) -> T:
        """Return the value itself: it never changes."""
        return self

    def __deepcopy__(self: T, _: object) -> T:
        """Return the value itself: it never changes."""
        return self

    def __replace__(self: T, **changes: Any) -> T:
        """Return a value with changed fields, for `copy.replace`."""
        return type(self)(**(self._items() | changes))  # type: ignore[attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the fields: unpickling checks them again."""
        return _made, (type(self), self._items())

    def __repr__(self) -> str:
        """Return the call that creates this value, without arguments that equal their defaults."""
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
    """Return a field at a time, in seconds: the value of a curve, or the field itself if it does not move."""
    if isinstance(given, Moving):
        return given(time)
    return given._at_time(time) if isinstance(given, Value) else given


def joined(given: Any) -> Any:
    """Return a vector with curves among its components as one curve, anything else as it is."""
    moving = [one for one in given if isinstance(one, Moving)] if isinstance(given, (tuple, list)) else ()
    return moving[0].in_vector(given) if moving else given


def times_of(given: Iterable[Any]) -> list[float]:
    """Return the key times of all curves among the given fields, in seconds, ascending."""
    return sorted({time for one in given if isinstance(one, Moving) for time in one.times})


class FieldTexts:
    """A class's docstring with the descriptions below its fields, for `help`.

    The descriptions are read from the source on each access.
    """

    shown = True
    """Whether descriptions are added; the site, which shows them field by field, sets this to False."""

    def __init__(self, text: str) -> None:
        """Store the docstring without descriptions."""
        self.text = text

    def __get__(self, _: object, kind: type) -> str:
        """Return the whole text."""
        if not self.shown:
            return self.text
        from .field_texts import with_fields

        return with_fields(kind, self.text)


def text_of(kind: Any) -> str:
    """Return a value class's docstring as it is written, without reading the source for its fields'."""
    text: str = vars(kind)["__doc__"].text
    return text


def items_of(value: Value) -> dict[str, Any]:
    """Return a value's fields by name."""
    return value._items()


def key_of(value: Value) -> tuple[Any, ...]:
    """Return the tuple by which a value is compared and hashed."""
    return value._key()


def moves(value: Value) -> bool:
    """Return whether a field of a value is a curve."""
    return value._moves


class Settings:
    """Base of mutable objects that check each assignment and refuse unknown attributes."""

    _checks: ClassVar[Mapping[str, Callable[[str, Any], Any]]]
    """The check of each attribute: it takes name and value, and returns the value to store."""
    _may_move: ClassVar[frozenset[str]] = frozenset()
    """The names of attributes that may be curves."""

    def __init_subclass__(cls) -> None:
        """Let `help` show the descriptions of the attributes."""
        cls.__doc__ = FieldTexts(cls.__doc__ or "")  # type: ignore[assignment]

    def __setattr__(self, name: str, given: Any) -> None:
        """Check and store a value; names with a leading underscore are private and not checked."""
        if name.startswith("_"):
            self.__dict__[name] = given
            return
        check = self._checks.get(name)
        if check is None:
            kind = type(self).__name__
            if name in self.__dict__:
                raise NotAssignableError(f"{kind}.{name} is fixed when the {kind} is made")
            raise NotAssignableError(f"{kind} has no attribute {name!r}{near(name, self._checks)}")
        if name in self._may_move:
            given = joined(given)
        if isinstance(given, Moving) and name in self._may_move:
            for time in given.times:
                check(name, given(time))
            self.__dict__[name] = given
        else:
            self.__dict__[name] = check(name, given)


@dataclass_transform(frozen_default=True, eq_default=False)
def value(*, init: bool = True, kw_only: bool = False) -> Callable[[type[T]], type[T]]:
    """Decorate a subclass of `Value`: set its fields; `init=False` if it defines `__init__`.

    `kw_only`: whether the fields of this class, not those of its bases, are passed by name only.
    """

    def decorate(kind: Any) -> type[T]:
        own = {name: text for name, text in kind.__annotations__.items() if not text.startswith("ClassVar")}
        kind._fields = getattr(kind, "_fields", {}) | own
        kind._defaults = kind._defaults | {name: vars(kind)[name] for name in own if name in vars(kind)}
        if not kw_only:
            kind.__match_args__ = tuple(dict.fromkeys((*kind.__match_args__, *own)))  # type: ignore[misc]
        kind.__dataclass_fields__ = _Late(_fields_of)
        if not init:
            kind.__init__ = says_near_names(kind.__init__)
        kind.__doc__ = FieldTexts(kind.__doc__ or "")
        decorated: type[T] = kind
        return decorated

    return decorate


def says_near_names(function: Function) -> Function:
    """Decorate a function: for an unknown keyword argument, its TypeError suggests the closest known one."""
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
    """Return a field's text, which Python can read back without any import, except for arrays."""
    if isinstance(value, float) and not math.isfinite(value):
        return f"float({str(value)!r})"
    if hasattr(value, "__array_interface__") and getattr(value, "ndim", 0) > 0:
        return f"<array of shape {getattr(value, 'shape', ())}>"
    if isinstance(value, tuple):
        return f"({', '.join(map(shown, value))}{',' if len(value) == 1 else ''})"
    return repr(value)


def _made(kind: Callable[..., T], arguments: dict[str, Any]) -> T:
    return kind(**arguments)
