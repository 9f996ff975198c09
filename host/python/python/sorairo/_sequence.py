"""Many suns in one call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sorairo
from ._sky import PARTS, Method
from ._values import (
    BYTES,
    Keys,
    Place,
    Time,
    called,
    directions_of,
    doubles,
    flat,
    given_keys,
    path,
    plain,
    refuse_two_suns,
    text,
    value_of,
    wavelengths_of,
)

if TYPE_CHECKING:
    import xarray

# Keys that are a list or a pair in one sky.
LISTS = {"render.bands", "sun.place"}


@dataclass(frozen=True)
class Sequence:
    """The result of `sequence`. The first axis of every array is the sun axis."""

    sun_elevation: NDArray[np.float64]
    """Elevation of each sun (degrees)."""
    sun_azimuth: NDArray[np.float64]
    """Azimuth of each sun (degrees, clockwise from north)."""
    radiance: NDArray[np.float64] | None
    """Spectral radiance (W·m⁻²·sr⁻¹·nm⁻¹): suns, then the shape of the directions, then wavelengths; `None` if no
    direction was given."""
    irradiance: dict[str, NDArray[np.float64]] | None
    """Spectral irradiance (W·m⁻²·nm⁻¹) by source: suns, then wavelengths; `None` if no surface was
    given."""
    wavelengths: NDArray[np.float64]
    """The wavelengths (nm), as they were given."""
    directions: tuple[NDArray[np.float64], NDArray[np.float64]] | None
    """Elevations and azimuths of the directions (degrees), as they were given."""
    surfaces: tuple[NDArray[np.float64], NDArray[np.float64]] | None
    """The tilt and the azimuth of each sun's surface (degrees)."""
    keys: dict[str, list[Any]]
    """The values that differ from sun to sun, by the keys of a scene."""
    scene: str
    """The complete scene of the first sun as TOML."""

    def to_xarray(self) -> xarray.Dataset:
        """The result as an `xarray.Dataset` with units, CF standard names and coordinates.

        The sun axis is `time` (UTC) if times were given, else `sun`. Directions are along `elevation` and `azimuth` if
        these were given as a column and a row, else along `direction`. Values that differ from sun to sun are
        coordinates too.

        Raises
        ------
        ImportError
            xarray is not installed.
        """
        from ._labels import labelled_sequence

        return labelled_sequence(self)


def sequence(
    preset: str | None = None,
    *,
    wavelengths: ArrayLike,
    sun_elevation: ArrayLike | None = None,
    sun_azimuth: ArrayLike | None = None,
    place: Place | None = None,
    time: Iterable[Time] | None = None,
    elevation: ArrayLike | None = None,
    azimuth: ArrayLike | None = None,
    method: Method = "fit",
    surface_tilt: ArrayLike | None = None,
    surface_azimuth: ArrayLike = 180.0,
    albedo: ArrayLike | str | PathLike[str] | None = None,
    scene: str | PathLike[str] | None = None,
    keys: Mapping[str, Any] | None = None,
) -> Sequence:
    """The radiance and the irradiance of many skies, in one call and on all cores.

    Parameters
    ----------
    wavelengths : array_like
        At most one axis (nm, 360 to 830).
    sun_elevation, sun_azimuth : array_like
        The suns (degrees), at most one axis each.
    place, time
        In their place: a place and times, as in `Sky`.
    elevation, azimuth : array_like, optional
        Directions of the radiance, broadcast against each other; both or none.
    surface_tilt, surface_azimuth : array_like, optional
        A surface (degrees); with a tilt its irradiance is computed. One surface, or one for each sun.
    albedo : array_like or str, optional
        Albedo of the ground, as in `Sky`: the same for all suns, or one for each.
    keys : dict, optional
        Any other keys of a scene. A value with an axis, such as hourly aerosol, has one for each sun.
    preset, method, scene
        As in `Sky` and `Sky.radiance`.

    All axes are broadcast: one value per sun, or a single value.

    Returns
    -------
    Sequence
        The values of `Sky.radiance` and `Sky.irradiance`, sun after sun.

    Raises
    ------
    ValueError
        As `Sky`, `Sky.radiance` and `Sky.irradiance`, with the number of the sun; if neither directions nor a surface
        are given.
    """
    if (elevation is None) != (azimuth is None):
        raise ValueError("elevation and azimuth of the directions are given together, or not at all")
    if elevation is None and surface_tilt is None:
        raise ValueError("sequence computes nothing: give elevation and azimuth, or surface_tilt")
    at = wavelengths_of(wavelengths)
    views = None if elevation is None or azimuth is None else directions_of(elevation, azimuth)
    given = {
        "sun.place": place,
        "sun.time": time,
        "sun.elevation": sun_elevation,
        "sun.azimuth": sun_azimuth,
        "ground.albedo": albedo,
    }
    both = given_keys(given, keys)
    refuse_two_suns(both)
    rows = {name: _rows(name, value) for name, value in both.items()}
    tilts, azimuths = None, None
    if surface_tilt is not None:
        tilts, azimuths = doubles("surface_tilt", surface_tilt, 1), doubles("surface_azimuth", surface_azimuth, 1)
    axes = {called(name): len(values) for name, values in rows.items() if values is not None}
    axes |= {name: len(axis) for name, axis in (("surface_tilt", tilts), ("surface_azimuth", azimuths)) if axis is not None and axis.ndim}
    count = _count(axes)
    shared = [(name, value_of(name, both[name])) for name, values in rows.items() if values is None]
    varied = {name: _repeated([value_of(name, value) for value in values], count) for name, values in rows.items() if values is not None}
    suns: list[Keys] = [[(name, values[i]) for name, values in varied.items()] for i in range(count)]
    surfaces = None
    if tilts is not None and azimuths is not None:
        surfaces = np.broadcast_to(tilts, count), np.broadcast_to(azimuths, count)
    flat_views, flat_surfaces = (None if pair is None else (flat(pair[0]), flat(pair[1])) for pair in (views, surfaces))
    name = None if preset is None else text("preset", preset)
    found, radiance, parts, first = _sorairo.sequence(
        name, path("scene", scene), shared, suns, flat(at), flat_views, text("method", method), flat_surfaces
    )
    elevations, sun_azimuths = np.array(found, dtype=np.float64).reshape(-1, 2).T
    return Sequence(
        elevations,
        sun_azimuths,
        None if views is None else radiance.reshape((count, *views[0].shape, *at.shape)),
        None if surfaces is None else {name: part.reshape((count, *at.shape)) for name, part in zip(PARTS, parts)},
        at,
        views,
        surfaces,
        varied,
        first,
    )


def _rows(name: str, value: Any) -> list[Any] | None:
    """A value for each sun; none if it is the same for all."""
    if name in LISTS or isinstance(value, (str, PathLike, *BYTES)) or getattr(value, "ndim", 1) == 0:
        return None
    if name == "sun.time":
        return list(value) if isinstance(value, Iterable) else None
    value = plain(name, value)
    if not isinstance(value, (list, tuple, range)):
        return None
    if any(isinstance(item, (list, tuple)) for item in value):
        raise ValueError(f"{called(name)} has 2 axes; at most 1 is allowed, that of the suns")
    return list(value)


def _count(axes: Mapping[str, int]) -> int:
    """The number of suns, for which each axis has as many values, or one."""
    count = next((length for length in axes.values() if length != 1), 1)
    for name, length in axes.items():
        if length not in (1, count):
            other = next(name for name, length in axes.items() if length == count)
            raise ValueError(f"{other} has {count} values and {name} {length}, and they cannot be broadcast against each other")
    return count


def _repeated(values: list[Any], count: int) -> list[Any]:
    """As many values as there are suns."""
    return values * count if len(values) == 1 else values
