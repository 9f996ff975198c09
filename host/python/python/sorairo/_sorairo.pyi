"""The part of sorairo that is written in Rust. Arrays are flat: an axis of wavelengths changes fastest."""

from collections.abc import Sequence
from os import PathLike
from typing import final

import numpy as np
from numpy.typing import NDArray

__all__ = ["Sky", "device_name", "run", "sequence"]

_Value = bool | int | float | str | list[float]
_Keys = list[tuple[str, _Value]]
_Doubles = NDArray[np.float64]
_Parts = tuple[_Doubles, _Doubles, _Doubles, _Doubles]

@final
class Sky:
    def __new__(cls, preset: str | None, file: str | PathLike[str] | None, keys: _Keys) -> Sky: ...
    @property
    def sun(self) -> tuple[float, float]: ...
    @property
    def scene(self) -> str: ...
    def radiance(self, elevations: _Doubles, azimuths: _Doubles, wavelengths: _Doubles, method: str) -> _Doubles: ...
    def xyz(self, elevations: _Doubles, azimuths: _Doubles) -> _Doubles: ...
    def render(self, size: tuple[int, int], wavelengths: _Doubles | None, device: str) -> NDArray[np.float32]: ...
    def irradiance(self, wavelengths: _Doubles, tilt: float, azimuth: float) -> _Parts: ...
    def illuminance(self, tilt: float, azimuth: float) -> tuple[float, float, float, float]: ...
    def sun_transmittance(self, wavelengths: _Doubles) -> _Doubles: ...

def sequence(
    preset: str | None,
    file: str | PathLike[str] | None,
    keys: _Keys,
    suns: list[_Keys],
    wavelengths: _Doubles,
    views: tuple[_Doubles, _Doubles] | None,
    method: str,
    surface: tuple[float, float] | None,
) -> tuple[list[tuple[float, float]], _Doubles, _Parts]: ...
def device_name(choice: str) -> str: ...
def run(arguments: Sequence[str]) -> int: ...
