"""Python's state in a checkpoint as JSON: unlike a pickle, reading it cannot run code.

Numbers, text, null and lists are plain JSON. Other types are objects: {"tuple": [...]}, {"bytes": base64},
{"dict": [[key, value], ...]}, {"array": [type, shape, base64, false for a scalar]}, and, for the classes in
`VALUES`, {"value": [name, fields]}.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from .._system.distributions import AlongNormal, Normal, Uniform
from .._values.curves import Combined, Curve
from .._values.values import items_of

__all__ = ["VALUES", "data_of", "value_of"]

VALUES: dict[str, type[Any]] = {
    kind.__name__: kind for kind in (AlongNormal, Combined, Curve, Normal, Uniform)
}
_NUMBERS = "biufc"


def data_of(value: Any) -> Any:
    """Encode a value as JSON data. Raises TypeError, naming its type, if it is not plain data."""
    kind = type(value)
    if value is None or kind in (bool, int, float, str):
        return value
    if kind is list:
        return [data_of(one) for one in value]
    if kind is tuple:
        return {"tuple": [data_of(one) for one in value]}
    if kind is dict:
        return {"dict": [[data_of(key), data_of(one)] for key, one in value.items()]}
    if kind is bytes:
        return {"bytes": base64.b64encode(value).decode()}
    if (kind is np.ndarray or isinstance(value, np.generic)) and value.dtype.kind in _NUMBERS:
        array = np.asarray(value)
        content = base64.b64encode(array.tobytes()).decode()
        return {"array": [array.dtype.str, list(array.shape), content, kind is np.ndarray]}
    if VALUES.get(kind.__name__) is kind:
        return {"value": [kind.__name__, data_of(items_of(value))]}
    raise TypeError(f"{kind.__qualname__} is not plain data: numbers, text, lists, dicts, arrays")


def value_of(data: Any) -> Any:
    """Decode the result of `data_of`. Raises ValueError, KeyError or TypeError for other data."""
    if isinstance(data, list):
        return [value_of(one) for one in data]
    if not isinstance(data, dict):
        return data
    ((kind, content),) = data.items()
    if kind == "tuple":
        return tuple(value_of(one) for one in content)
    if kind == "dict":
        return {value_of(key): value_of(one) for key, one in content}
    if kind == "bytes":
        return base64.b64decode(content, validate=True)
    if kind == "array":
        dtype, shape, text, whole = content
        if np.dtype(dtype).kind not in _NUMBERS:
            raise ValueError(f"an array of {dtype}")
        array = np.frombuffer(base64.b64decode(text, validate=True), dtype).reshape(shape).copy()
        return array if whole else array[()]
    if kind == "value":
        name, fields = content
        return VALUES[name](**value_of(fields))
    raise ValueError(f"{kind!r} is not a kind of value")
