"""Arrays with names, units and coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ._sequence import Sequence

Doubles = NDArray[np.float64]
# Names of dimensions, values, attributes.
Variable = tuple[tuple[str, ...], Any, dict[str, str]]

IRRADIANCE = {"direct": "from the sun", "diffuse": "from the sky", "ground": "from below", "global": "from everywhere"}

ELEVATION = {"long_name": "elevation above the horizon", "units": "degree"}
AZIMUTH = {"long_name": "azimuth clockwise from north", "units": "degree"}
WAVELENGTH = {"standard_name": "radiation_wavelength", "units": "nm"}
STOKES = {
    "long_name": "Stokes vector of the sky, Q > 0 in the vertical plane, U > 0 45 degrees counterclockwise of it as seen",
    "units": "W m-2 sr-1 nm-1",
}
SUN_ELEVATION = {"standard_name": "solar_elevation_angle", "units": "degree"}
SUN_AZIMUTH = {"standard_name": "solar_azimuth_angle", "units": "degree"}


def labelled(
    sun: tuple[float, float],
    scene: str,
    directions: list[Doubles],
    wavelengths: Doubles,
    radiance: Doubles,
    irradiance: dict[str, Doubles],
    stokes: Doubles | None = None,
) -> xarray.Dataset:
    """A dataset after the CF conventions; quantities that have a standard name there bear it."""
    variables = {"radiance": _radiance(("elevation", "azimuth", "wavelength"), radiance)}
    variables |= _irradiance(("wavelength",), irradiance, "level ground")
    coordinates: dict[str, Variable] = {
        "elevation": (("elevation",), directions[0], ELEVATION),
        "azimuth": (("azimuth",), directions[1], AZIMUTH),
        "wavelength": (("wavelength",), wavelengths, WAVELENGTH),
        "sun_elevation": ((), sun[0], SUN_ELEVATION),
        "sun_azimuth": ((), sun[1], SUN_AZIMUTH),
    }
    if stokes is not None:
        variables["stokes"] = ("elevation", "azimuth", "wavelength", "parameter"), stokes, STOKES
        coordinates["parameter"] = (("parameter",), ["I", "Q", "U"], {"long_name": "parameter of the Stokes vector"})
    return _dataset(variables, coordinates, {"scene": scene})


def labelled_sequence(found: Sequence) -> xarray.Dataset:
    """The same of many suns."""
    times = found.keys.get("sun.time")
    suns = "sun" if times is None else "time"
    at = ("wavelength",) if found.wavelengths.ndim else ()
    coordinates: dict[str, Variable] = {
        "wavelength": (at, found.wavelengths, WAVELENGTH),
        "sun_elevation": ((suns,), found.sun_elevation, SUN_ELEVATION),
        "sun_azimuth": ((suns,), found.sun_azimuth, SUN_AZIMUTH),
    }
    if times is not None:
        utc = np.array([_utc(time) for time in times], dtype="datetime64[us]")
        coordinates["time"] = ((suns,), utc, {"standard_name": "time", "long_name": "time in UTC"})
    for key in found.keys.keys() - {"sun.time", "sun.elevation", "sun.azimuth"}:
        coordinates[key] = ((suns,), np.array(found.keys[key]), {"long_name": f"{key} of the scene"})
    variables: dict[str, Variable] = {}
    if found.radiance is not None and found.directions is not None:
        dimensions, of_directions = _directions(*found.directions)
        coordinates |= of_directions
        variables["radiance"] = _radiance((suns, *dimensions, *at), found.radiance)
    if found.irradiance is not None and found.surfaces is not None:
        variables |= _irradiance((suns, *at), found.irradiance, "a surface")
        coordinates["surface_tilt"] = ((suns,), found.surfaces[0], {"long_name": "angle of the normal to the zenith", "units": "degree"})
        coordinates["surface_azimuth"] = ((suns,), found.surfaces[1], AZIMUTH)
    return _dataset(variables, coordinates, {"scene_of_first_sun": found.scene})


def _directions(elevation: Doubles, azimuth: Doubles) -> tuple[tuple[str, ...], dict[str, Variable]]:
    """The dimensions of directions, and their coordinates."""
    is_grid = elevation.ndim == 2 and elevation.size > 0 and (elevation == elevation[:, :1]).all() and (azimuth == azimuth[:1]).all()
    if is_grid:
        axes: dict[str, Variable] = {
            "elevation": (("elevation",), elevation[:, 0], ELEVATION),
            "azimuth": (("azimuth",), azimuth[0], AZIMUTH),
        }
        return ("elevation", "azimuth"), axes
    several = elevation.ndim > 1
    dimensions = tuple(f"direction_{i}" if several else "direction" for i in range(elevation.ndim))
    return dimensions, {"elevation": (dimensions, elevation, ELEVATION), "azimuth": (dimensions, azimuth, AZIMUTH)}


def _radiance(dimensions: tuple[str, ...], values: Doubles) -> Variable:
    attributes = {
        "standard_name": "downwelling_radiance_per_unit_wavelength_in_air",
        "long_name": "spectral radiance of the sky without the sun's disc",
        "units": "W m-2 sr-1 nm-1",
    }
    return dimensions, values, attributes


def _irradiance(dimensions: tuple[str, ...], parts: dict[str, Doubles], surface: str) -> dict[str, Variable]:
    variables: dict[str, Variable] = {}
    for name, values in parts.items():
        attributes = {"long_name": f"spectral irradiance of {surface} {IRRADIANCE[name]}", "units": "W m-2 nm-1"}
        if name == "global" and surface == "level ground":
            attributes["standard_name"] = "surface_downwelling_radiative_flux_per_unit_wavelength_in_air"
        variables[f"{name}_irradiance"] = dimensions, values, attributes
    return variables


def _utc(time: str) -> np.datetime64:
    """The time of a text with its offset from UTC."""
    time = time.upper()
    if time.endswith("Z"):
        return np.datetime64(time[:-1])
    local, sign, offset = time[:-6], time[-6], time[-5:]
    minutes = int(offset[:2]) * 60 + int(offset[3:])
    return np.datetime64(local) - np.timedelta64(minutes if sign == "+" else -minutes, "m")


def _dataset(variables: dict[str, Variable], coordinates: dict[str, Variable], attributes: dict[str, str]) -> xarray.Dataset:
    return xarray.Dataset(variables, coordinates, {"Conventions": "CF-1.11", "source": "sorairo", **attributes})
