"""Converts values of programs to values of fields. Errors name the field whose value does not fit."""

import difflib

import numpy as np


def refuse_unknown(values, names, type_name, path):
    """Raises an exception, because a mapping has a key that is not a field."""
    unknown = next(key for key in values if key not in names)
    near = difflib.get_close_matches(str(unknown), names, 1)
    where = f"'{path}': " if path else ""
    raise TypeError(f"{where}{type_name} has no field '{unknown}'" + (f"; did you mean '{near[0]}'?" if near else ""))


def fit_array(value, dtype, path):
    """Returns a contiguous array of one dimension with this dtype. Several dimensions are flattened row by row."""
    given = _array_of(value, path)
    if given.ndim == 0:
        raise TypeError(f"'{path}' is {value!r}; a list or an array was expected")
    flat = given.reshape(-1)
    if flat.size == 0:
        return np.empty(0, dtype)
    if flat.dtype == dtype:
        return np.ascontiguousarray(flat)
    _check_kind(flat, dtype, path)
    if dtype.kind in "iu":
        _check_range(flat, np.iinfo(dtype), path)
    with np.errstate(over="ignore"):
        fitting = flat.astype(dtype)
    if dtype.kind == "f" and flat.dtype.kind == "f":
        lost = np.isinf(fitting) & np.isfinite(flat)
        if lost.any():
            i = int(lost.argmax())
            raise ValueError(f"'{path}[{i}]' is {flat[i]}; a number of {8 * dtype.itemsize} bits was expected")
    return fitting


def _array_of(value, path):
    if isinstance(value, (bytes, bytearray)):
        return np.frombuffer(value, np.uint8)
    if isinstance(value, (str, dict, set)) or value is None:
        raise TypeError(f"'{path}' is {value!r:.60}; a list or an array of numbers was expected")
    refuse = getattr(type(value), "_refuse", None)
    if refuse:
        refuse(value)
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ValueError(f"'{path}' is no array of numbers: {error}") from None


def _check_kind(flat, dtype, path):
    allowed = {"b": "b", "i": "biu", "u": "biu", "f": "biuf", "S": "S"}[dtype.kind]
    if flat.dtype.kind not in allowed or (dtype.kind == "S" and flat.dtype.itemsize != 1):
        raise TypeError(f"'{path}' has elements of {flat.dtype}, such as {flat[0]!r:.60}; {dtype} was expected")


def _check_range(flat, limits, path):
    if flat.dtype.kind == "b":
        return
    for i in (int(flat.argmin()), int(flat.argmax())):
        if not limits.min <= int(flat[i]) <= limits.max:
            raise ValueError(
                f"'{path}[{i}]' is {flat[i]}; an integer from {limits.min} to {limits.max} was expected")
