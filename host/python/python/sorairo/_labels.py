"""Arrays with names, units and coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

Doubles = NDArray[np.float64]

IRRADIANCE = {"direct": "from the sun", "diffuse": "from the sky", "ground": "from below", "global": "from everywhere"}


def labelled(
    sun: tuple[float, float],
    scene: str,
    directions: list[Doubles],
    wavelengths: Doubles,
    radiance: Doubles,
    irradiance: dict[str, Doubles],
) -> xarray.Dataset:
    """A dataset after the CF conventions; quantities that have a standard name there bear it."""
    of_radiance = {
        "standard_name": "downwelling_radiance_per_unit_wavelength_in_air",
        "long_name": "spectral radiance of the sky without the sun's disc",
        "units": "W m-2 sr-1 nm-1",
    }
    variables: dict[str, Any] = {"radiance": (("elevation", "azimuth", "wavelength"), radiance, of_radiance)}
    for name, values in irradiance.items():
        attributes = {"long_name": f"spectral irradiance of level ground {IRRADIANCE[name]}", "units": "W m-2 nm-1"}
        if name == "global":
            attributes["standard_name"] = "surface_downwelling_radiative_flux_per_unit_wavelength_in_air"
        variables[f"{name}_irradiance"] = (("wavelength",), values, attributes)
    coordinates = {
        "elevation": ("elevation", directions[0], {"long_name": "elevation above the horizon", "units": "degree"}),
        "azimuth": ("azimuth", directions[1], {"long_name": "azimuth clockwise from north", "units": "degree"}),
        "wavelength": ("wavelength", wavelengths, {"standard_name": "radiation_wavelength", "units": "nm"}),
        "sun_elevation": ((), sun[0], {"standard_name": "solar_elevation_angle", "units": "degree"}),
        "sun_azimuth": ((), sun[1], {"standard_name": "solar_azimuth_angle", "units": "degree"}),
    }
    return xarray.Dataset(variables, coordinates, {"Conventions": "CF-1.11", "source": "sorairo", "scene": scene})
