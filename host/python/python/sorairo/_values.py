"""From Python's values to those of a scene, and to arrays."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timedelta, timezone
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Place = Union[str, tuple[float, float]]
Time = Union[str, datetime]
Keys = list[tuple[str, Any]]
Doubles = NDArray[np.float64]

SUN = {"sun.elevation": "sun_elevation", "sun.azimuth": "sun_azimuth"}

# Parameters that keys have.
PARAMETERS = {**SUN, "sun.place": "place", "sun.time": "time", "ground.albedo": "albedo"}

BYTES = (bytes, bytearray, memoryview)


def scene_keys(given: Mapping[str, Any], keys: Mapping[str, Any] | None) -> Keys:
    """The keys of a scene that are given, once each: those of parameters, and those of the dict `keys`."""
    both = given_keys(given, keys)
    refuse_two_suns(both)
    return [(name, value_of(name, value)) for name, value in both.items()]


def given_keys(given: Mapping[str, Any], keys: Mapping[str, Any] | None) -> dict[str, Any]:
    """The same before they are turned into what the extension takes."""
    both = {name: value for name, value in given.items() if value is not None}
    if not isinstance(keys, (Mapping, type(None))):
        raise ValueError(f"keys is {shown(keys)}; a dict of keys and values is wanted")
    for name, value in (keys or {}).items():
        text("keys", name)
        if name == "preset":
            raise ValueError("keys: preset is the first parameter, not one of the keys")
        if name in both:
            raise ValueError(f"keys: {name} is given as a parameter too; give it once")
        both[name] = value
    return both


def refuse_two_suns(keys: Iterable[str]) -> None:
    """Refuses a direction of the sun beside a place or a time."""
    placed = [name for name in ("sun.place", "sun.time") if name in keys]
    for name, parameter in SUN.items():
        if placed and name in keys:
            raise ValueError(
                f"{parameter} ({name}) and {placed[0][4:]} ({placed[0]}) cannot both be given: a place and a time say where the sun is"
            )


def value_of(name: str, value: Any) -> Any:
    """A value as the extension takes it."""
    if name == "sun.place" and not isinstance(value, str):
        latitude, longitude = pair("place", value, "latitude and longitude in degrees")
        return f"{_meant(number('place', latitude), 90)!r},{_meant(number('place', longitude), 180)!r}"
    if name == "sun.time":
        return moment(value)
    value = plain(name, value)
    if isinstance(value, (bool, float)):
        return value
    if isinstance(value, int):
        # What is beyond the extension's whole numbers is far beyond every range.
        return value if -(2**63) <= value < 2**63 else number(called(name), value)
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, str):
        return text(called(name), value)
    if name == "atmosphere.aerosol" and isinstance(value, Sequence) and all(isinstance(mode, Mapping) for mode in value):
        return [{text(name, key): value_of(f"{name}.{key}", part) for key, part in mode.items()} for mode in value]
    if isinstance(value, Sequence) and not isinstance(value, BYTES):
        return doubles(called(name), value, 1).tolist()
    raise ValueError(f"{called(name)} is {shown(value)}; a number, a text, true or false or a list of numbers is wanted")


def _meant(value: float, end: float) -> float:
    """An angle that was meant to be an end of its range, and missed it by what rounding leaves in a long row of even
    steps: that end."""
    return math.copysign(end, value) if end < abs(value) <= end * (1 + 1e-9) else value


def called(name: str) -> str:
    """A key as sentences name it: by its parameter, where it has one."""
    return f"{PARAMETERS[name]} ({name})" if name in PARAMETERS else name


def plain(name: str, value: Any) -> Any:
    """A value of numpy, or of what numpy reads as an array, as one of Python's own."""
    if isinstance(value, (np.ndarray, np.generic)) or hasattr(value, "__array__"):
        refuse_masked(called(name), value)
        return np.asarray(value).tolist()
    return value


def moment(value: Any) -> str:
    """A time as text with its offset from UTC."""
    if isinstance(value, str):
        return text("time", value)
    if not isinstance(value, datetime):
        if isinstance(value, np.datetime64) or getattr(value, "dtype", np.dtype(float)).kind == "M":
            raise ValueError(
                f"time is {shown(str(np.asarray(value)[()]))}, and numpy's times have no offset from UTC; give a datetime with a tzinfo, such as"
                " pandas.DatetimeIndex(times, tz='UTC'), or a text with an offset"
            )
        raise ValueError(f"time is {shown(value)}; a datetime with a tzinfo or a text with an offset from UTC is wanted")
    if value != value:
        raise ValueError(f"time is {value}; a datetime with a tzinfo or a text with an offset from UTC is wanted")
    offset = value.utcoffset()
    if offset is None:
        raise ValueError(f"time is {value}, which has no offset from UTC; give it a tzinfo, such as datetime.timezone.utc")
    if offset % timedelta(minutes=1):
        # The form of a text has hours and minutes alone; local mean times have seconds.
        try:
            value = value.astimezone(timezone.utc)
        except OverflowError:
            raise ValueError(f"time is {value}, which is no time of a calendar year of UTC from 1 to 9999") from None
    return str(value.isoformat())


def pair(name: str, value: Any, wanted: str) -> tuple[Any, Any]:
    """Two values."""
    try:
        if isinstance(value, BYTES):
            raise TypeError
        first, second = value
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {shown(value)}; {wanted} are wanted") from None
    return first, second


def text(name: str, value: Any) -> str:
    """A text that can be written."""
    try:
        if isinstance(value, str):
            value.encode()
            return value
    except UnicodeEncodeError:
        raise ValueError(f"{name} is {shown(value)}, which holds half a character and is no text") from None
    raise ValueError(f"{name} is {shown(value)}; a text is wanted")


def path(name: str, value: Any) -> str | None:
    """The name of a file, if there is one."""
    if value is None:
        return None
    try:
        return os.fsdecode(os.fsencode(value))
    except (TypeError, UnicodeEncodeError):
        raise ValueError(f"{name} is {shown(value)}; the name of a file is wanted") from None


def shown(value: Any) -> str:
    """A value in a sentence: in one line, and no longer than anyone reads."""
    most = 80
    if isinstance(value, np.generic):
        value = value.item()
    try:
        line = " ".join(repr(value).split())
    except Exception:  # Python writes no number of more than some thousand digits; and what a stranger's __repr__ does, nobody knows.
        line = f"a {type(value).__name__} too long to show"
    return line if len(line) <= most else line[: most - 3] + "..."


def doubles(name: str, values: ArrayLike, most_axes: int) -> Doubles:
    """Numbers as an array of so many axes at most."""
    refuse_masked(name, values)
    try:
        array = np.asarray(values)
        # Bytes, times and complex numbers become numbers that nobody meant.
        if array.dtype.kind in "ScMmV":
            raise TypeError
        array = array.astype(np.float64, copy=False)
    except OverflowError:
        raise ValueError(f"{name} is {shown(values)}, which is beyond every number that can be computed with") from None
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {shown(values)}; numbers are wanted") from None
    if array.ndim > most_axes:
        at_most = "one number is wanted" if most_axes == 0 else f"at most {most_axes} are allowed"
        raise ValueError(f"{name} has {array.ndim} axes; {at_most}")
    return array


def refuse_masked(name: str, values: Any) -> None:
    """Refuses an array in which something is masked, which numpy would compute with all the same."""
    if isinstance(values, np.ma.MaskedArray):
        masked = int(np.count_nonzero(np.broadcast_to(values.mask, values.shape)))
        if masked:
            raise ValueError(f"{name} has {masked} masked of {values.size} values; fill them or leave them out")
    elif isinstance(values, (list, tuple)):
        for value in values:
            if isinstance(value, (np.ma.MaskedArray, list, tuple)):
                refuse_masked(name, value)


def flat(array: Doubles) -> Doubles:
    """An array as one axis without gaps."""
    return np.ascontiguousarray(array).reshape(-1)


def number(name: str, value: Any) -> float:
    """One number."""
    return float(doubles(name, value, 0))


def wavelengths_of(values: ArrayLike) -> Doubles:
    """Wavelengths, of which there is at least one."""
    wavelengths = doubles("wavelengths", values, 1)
    if wavelengths.size == 0:
        raise ValueError("wavelengths is empty; at least one is wanted")
    return wavelengths


def broadcast(one: str, ones: ArrayLike, other: str, others: ArrayLike) -> tuple[Doubles, Doubles]:
    """Two arrays of numbers, broadcast against each other."""
    first, second = doubles(one, ones, 32), doubles(other, others, 32)
    try:
        first, second = np.broadcast_arrays(first, second)
    except ValueError:
        raise ValueError(
            f"{one} of shape {first.shape} and {other} of shape {second.shape} cannot be broadcast against each other"
        ) from None
    return first, second


def directions_of(elevation: ArrayLike, azimuth: ArrayLike) -> tuple[Doubles, Doubles]:
    """Elevations and azimuths, broadcast against each other."""
    return broadcast("elevation", elevation, "azimuth", azimuth)


def surfaces_of(tilt: ArrayLike, azimuth: ArrayLike) -> tuple[Doubles, Doubles]:
    """Tilts and azimuths of surfaces, broadcast against each other."""
    return broadcast("surface_tilt", tilt, "surface_azimuth", azimuth)
