"""Many suns in one call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sorairo
from ._sky import PARTS, Method
from ._values import Keys, Place, Time, directions_of, doubles, flat, number, scene_keys, wavelengths_of


@dataclass(frozen=True)
class Sequence:
    """What `sequence` found: the first axis of every array is that of the suns."""

    sun_elevation: NDArray[np.float64]
    """Elevation of each sun (degrees)."""
    sun_azimuth: NDArray[np.float64]
    """Azimuth of each sun (degrees, clockwise from north)."""
    radiance: NDArray[np.float64] | None
    """Spectral radiance (W·m⁻²·sr⁻¹·nm⁻¹): suns, then the shape of the directions, then wavelengths; `None` if no direction was given."""
    irradiance: dict[str, NDArray[np.float64]] | None
    """Spectral irradiance (W·m⁻²·nm⁻¹) by where it comes from: suns, then wavelengths; `None` if no surface was given."""


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
    surface_tilt: float | None = None,
    surface_azimuth: float = 180.0,
    albedo: float | str | PathLike[str] | None = None,
    scene: str | PathLike[str] | None = None,
    keys: Mapping[str, Any] | None = None,
) -> Sequence:
    """The radiance and the irradiance of many skies that differ by their suns, in one call and on all cores.

    Parameters
    ----------
    wavelengths : array_like
        At most one axis (nm, 360 to 830).
    sun_elevation, sun_azimuth : array_like
        The suns (degrees), at most one axis each, broadcast against each other.
    place, time
        In their place: a place and times, as in `Sky`.
    elevation, azimuth : array_like, optional
        Directions in which the radiance is computed, broadcast against each other; both or none.
    surface_tilt, surface_azimuth : float, optional
        A surface (degrees) whose irradiance is computed if its tilt is given.
    preset, method, albedo, scene, keys
        As in `Sky` and `Sky.radiance`.

    Returns
    -------
    Sequence
        The numbers of `Sky.radiance` and `Sky.irradiance`, sun after sun.

    Raises
    ------
    ValueError
        As `Sky`, `Sky.radiance` and `Sky.irradiance`, with the number of the sun; if neither directions nor a surface are given.
    """
    if (elevation is None) != (azimuth is None):
        raise ValueError("elevation and azimuth of the directions are given together, or not at all")
    if elevation is None and surface_tilt is None:
        raise ValueError("sequence computes nothing: give elevation and azimuth, or surface_tilt")
    at = wavelengths_of(wavelengths)
    views = None if elevation is None or azimuth is None else directions_of(elevation, azimuth)
    surface = None
    if surface_tilt is not None:
        surface = number("surface_tilt", surface_tilt), number("surface_azimuth", surface_azimuth)
    shared, suns = _suns(sun_elevation, sun_azimuth, place, time, {"ground.albedo": albedo}, keys)
    flat_views = None if views is None else (flat(views[0]), flat(views[1]))
    found, radiance, parts = _sorairo.sequence(preset, scene, shared, suns, flat(at), flat_views, method, surface)
    elevations, azimuths = np.array(found, dtype=np.float64).reshape(-1, 2).T
    return Sequence(
        elevations,
        azimuths,
        None if views is None else radiance.reshape((len(suns), *views[0].shape, *at.shape)),
        None if surface is None else {name: part.reshape((len(suns), *at.shape)) for name, part in zip(PARTS, parts)},
    )


def _suns(
    elevation: ArrayLike | None,
    azimuth: ArrayLike | None,
    place: Place | None,
    time: Iterable[Time] | None,
    given: Mapping[str, Any],
    keys: Mapping[str, Any] | None,
) -> tuple[Keys, list[Keys]]:
    """The keys that all skies share, and those of each sun."""
    if time is not None:
        times = [time] if isinstance(time, str) or not isinstance(time, Iterable) else list(time)
        of_suns = [{"sun.place": place, "sun.time": moment, "sun.elevation": elevation, "sun.azimuth": azimuth} for moment in times]
    else:
        named = (("sun_elevation", elevation), ("sun_azimuth", azimuth))
        axes = [None if value is None else doubles(name, value, 1) for name, value in named]
        try:
            elevations, azimuths = np.broadcast_arrays(*(np.nan if axis is None else axis for axis in axes))
        except ValueError:
            raise ValueError("sun_elevation and sun_azimuth cannot be broadcast against each other") from None
        pairs = zip(np.atleast_1d(elevations).tolist(), np.atleast_1d(azimuths).tolist())
        of_suns = [
            {
                "sun.place": place,
                "sun.elevation": None if axes[0] is None else one,
                "sun.azimuth": None if axes[1] is None else other,
            }
            for one, other in pairs
        ]
    return scene_keys(given, keys), [scene_keys(sun, None) for sun in of_suns]
