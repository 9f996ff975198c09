"""The clear sky in full spectrum, as arrays.

Conventions of all functions: angles in degrees, elevations above the horizon, azimuths clockwise from north;
wavelengths in nm; arrays of elevations and azimuths are broadcast against each other, and an axis of wavelengths comes
last.

>>> import sorairo
>>> sky = sorairo.Sky("standard", sun_elevation=10, sun_azimuth=250)
>>> sky.radiance(elevation=45, azimuth=[0, 90, 180], wavelengths=[450, 550, 650]).shape
(3, 3)

A wrong value raises `ValueError` in one sentence that names the parameter, its value and what is allowed; a device that
fails raises `RuntimeError`. Computation releases Python's lock, and Ctrl-C interrupts it.
"""

from ._sequence import Sequence, sequence
from ._sky import Sky, device

__all__ = ["Sequence", "Sky", "device", "sequence"]
