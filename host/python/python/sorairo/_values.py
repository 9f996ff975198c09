"""From Python's values to those of a scene, and to arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Place = Union[str, tuple[float, float]]
Time = Union[str, datetime]
Keys = list[tuple[str, Any]]

SUN = {"sun.elevation": "sun_elevation", "sun.azimuth": "sun_azimuth"}


def scene_keys(given: Mapping[str, Any], keys: Mapping[str, Any] | None) -> Keys:
    """The keys of a scene that are given, once each: those of parameters, and those of the dict `keys`."""
    both = {name: value for name, value in given.items() if value is not None}
    for name, value in (keys or {}).items():
        if name == "preset":
            raise ValueError("keys: preset is the first parameter, not one of the keys")
        if name in both:
            raise ValueError(f"keys: {name} is given as a parameter too; give it once")
        both[name] = value
    placed = [name for name in ("sun.place", "sun.time") if name in both]
    for name, parameter in SUN.items():
        if placed and name in both:
            raise ValueError(
                f"{parameter} ({name}) and {placed[0][4:]} ({placed[0]}) cannot both be given: a place and a time say where the sun is"
            )
    return [(name, value_of(name, value)) for name, value in both.items()]


def value_of(name: str, value: Any) -> Any:
    """A value as the extension takes it."""
    if name == "sun.place" and not isinstance(value, str):
        latitude, longitude = pair("place", value, "latitude and longitude in degrees")
        return f"{latitude},{longitude}"
    if isinstance(value, datetime):
        if value.tzinfo is None:
            raise ValueError(f"time is {value}, which has no offset from UTC; give it a tzinfo, such as datetime.timezone.utc")
        return value.isoformat()
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, Sequence):
        return [float(item) for item in value]
    if hasattr(value, "__fspath__"):
        return str(value)
    raise ValueError(f"{name} is {value!r}; a number, a text, true or false or a list of numbers is wanted")


def pair(name: str, value: Any, wanted: str) -> tuple[Any, Any]:
    """Two values."""
    try:
        first, second = value
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}; {wanted} are wanted") from None
    return first, second


def doubles(name: str, values: ArrayLike, most_axes: int) -> NDArray[np.float64]:
    """Numbers as an array of so many axes at most."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {values!r}; numbers are wanted") from None
    if array.ndim > most_axes:
        raise ValueError(f"{name} has {array.ndim} axes; at most {most_axes} are allowed")
    return array


def flat(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """An array as one axis without gaps."""
    return np.ascontiguousarray(array).reshape(-1)


def number(name: str, value: float) -> float:
    """One number."""
    return float(doubles(name, value, 0))


def wavelengths_of(values: ArrayLike) -> NDArray[np.float64]:
    """Wavelengths, of which there is at least one."""
    wavelengths = doubles("wavelengths", values, 1)
    if wavelengths.size == 0:
        raise ValueError("wavelengths is empty; at least one is wanted")
    return wavelengths


def directions_of(elevation: ArrayLike, azimuth: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Elevations and azimuths, broadcast against each other."""
    elevations, azimuths = doubles("elevation", elevation, 32), doubles("azimuth", azimuth, 32)
    try:
        elevations, azimuths = np.broadcast_arrays(elevations, azimuths)
    except ValueError:
        raise ValueError(
            f"elevation of shape {elevations.shape} and azimuth of shape {azimuths.shape} cannot be broadcast against each other"
        ) from None
    return elevations, azimuths
