"""One sky."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sorairo
from ._values import (
    Doubles,
    Place,
    Time,
    broadcast,
    directions_of,
    doubles,
    flat,
    pair,
    path,
    scene_keys,
    shown,
    surfaces_of,
    text,
    wavelengths_of,
)

if TYPE_CHECKING:
    import xarray

Method = Literal["fit", "dense"]
Frame = Literal["vertical", "camera"]

# Most pixels along a side of an image.
LONGEST_SIDE = 2**23

PARTS = ("direct", "diffuse", "ground", "global")


def device(choice: str = "auto") -> str:
    """The name of the device that `choice` stands for in `Sky.render`.

    `"auto"` is the best graphics device, or the CPU if there is none. `"cpu"`, `"gpu"` or part of a device's name
    select another.

    Raises `ValueError` for an unknown device, `RuntimeError` if the device cannot be opened.
    """
    return _sorairo.device_name(text("device", choice))


@dataclass(frozen=True)
class AlphaOpic:
    """An α-opic quantity of CIE S 026 on a surface: light weighted by one kind of photoreceptors in the eye."""

    irradiance: dict[str, Any]
    """The α-opic irradiance (W·m⁻²) by source: the parts of `Sky.irradiance`."""
    edi: dict[str, Any]
    """The α-opic equivalent daylight illuminance, EDI (lx): the illuminance of daylight D65 that has the same α-opic
    irradiance."""


class Sky:
    """A clear sky: an atmosphere over a ground, a sun, and an observer.

    Parameters
    ----------
    preset : str, optional
        The atmosphere: `"standard"` (the default: the Earth's, with clean continental aerosol over grass), `"earth"`,
        `"paper"`, `"hazy"`, `"mountain"`, `"mars"` or `"no-ozone"`.
    sun_elevation, sun_azimuth : float, optional
        Position of the sun's centre (degrees, −90 to 90, and clockwise from north, −360 to 360). The direction is
        geometric, without refraction. pvlib: `elevation` and `azimuth`.
    albedo : float or str, optional
        Albedo of the ground: 0 to 1, a measured surface such as `"grass"` or `"snow"`, or a CSV file.
    place : (float, float) or str, optional
        Latitude and longitude on the Earth (degrees north and east). With `time` they determine the sun's direction and
        distance, by the Solar Position Algorithm (Reda and Andreas 2004, DOI 10.1016/j.solener.2003.12.003).
    time : datetime.datetime or str, optional
        A time with an offset from UTC.
    scene : path, optional
        A scene file in TOML, which all other parameters override.
    keys : dict, optional
        Any other keys of a scene by their dotted names, such as `{"atmosphere.aerosol.optical_depth": 0.2}`;
        `docs/scene-reference.md` lists them. Several aerosols are a list of dicts:
        `{"atmosphere.aerosol": [{"kind": "urban"}, {"kind": "stratospheric"}]}`.

    Raises
    ------
    ValueError
        A value out of range, an unknown key, an invalid scene file.

    Notes
    -----
    The constructor plans the sky, which takes some tens of ms, and up to a second in twilight; queries are fast. A sky
    is immutable, and threads may share it. It can be copied, and pickled as its scene.
    """

    def __init__(
        self,
        preset: str | None = None,
        *,
        sun_elevation: float | None = None,
        sun_azimuth: float | None = None,
        albedo: float | str | PathLike[str] | None = None,
        place: Place | None = None,
        time: Time | None = None,
        scene: str | PathLike[str] | None = None,
        keys: Mapping[str, Any] | None = None,
    ) -> None:
        given = {
            "sun.place": place,
            "sun.time": time,
            "ground.albedo": albedo,
            "sun.elevation": sun_elevation,
            "sun.azimuth": sun_azimuth,
        }
        name = None if preset is None else text("preset", preset)
        self._sky = _sorairo.Sky(name, path("scene", scene), scene_keys(given, keys))

    def __repr__(self) -> str:
        return f"<sorairo.Sky with the sun at elevation {self.sun_elevation:.2f}°, azimuth {self.sun_azimuth:.2f}°>"

    @property
    def sun_elevation(self) -> float:
        """Elevation of the sun's centre (degrees), without refraction."""
        return self._sky.sun[0]

    @property
    def sun_azimuth(self) -> float:
        """Azimuth of the sun (degrees, clockwise from north)."""
        return self._sky.sun[1]

    @property
    def scene(self) -> str:
        """The complete scene as TOML: a scene file that reproduces this sky, here and in the command."""
        return self._sky.scene

    def radiance(
        self, elevation: ArrayLike, azimuth: ArrayLike, wavelengths: ArrayLike, method: Method = "fit"
    ) -> NDArray[np.float64]:
        """Spectral radiance of the sky in directions (W·m⁻²·sr⁻¹·nm⁻¹), without the sun's disc.

        Parameters
        ----------
        elevation, azimuth : array_like
            Directions (degrees; −90 to 90 above the horizon, −360 to 360 clockwise from north), broadcast against each
            other. Below the horizon is the ground.
        wavelengths : array_like
            At most one axis (nm, 360 to 830; in measured air 280 to 2500).
        method : {"fit", "dense"}
            `"fit"` uses the fit through the bands, as images do; `"dense"` integrates at each wavelength, which is
            exact and slower.

        Returns
        -------
        ndarray of float64
            The shape of the directions, followed by a wavelength axis. The values equal those of the command
            `sorairo spectrum`. With the flat sun they are relative (sr⁻¹).

        Raises
        ------
        ValueError
            A direction or a wavelength out of range.
        """
        elevations, azimuths = directions_of(elevation, azimuth)
        at = wavelengths_of(wavelengths)
        found = self._sky.radiance(flat(elevations), flat(azimuths), flat(at), text("method", method))
        return found.reshape(elevations.shape + at.shape)

    def stokes(
        self, elevation: ArrayLike, azimuth: ArrayLike, wavelengths: ArrayLike, frame: Frame = "vertical"
    ) -> NDArray[np.float64]:
        """Stokes vectors of the sky in directions (W·m⁻²·sr⁻¹·nm⁻¹), without the sun's disc.

        `Q > 0` if the electric vector lies in the plane of the frame, `U > 0` if it lies 45° counterclockwise of it for
        the observer. The degree of polarisation is ``hypot(Q, U) / I``, and the angle of the electric vector from the
        plane is ``arctan2(U, Q) / 2``. Take means of `Q` and `U`, not of these.

        Parameters
        ----------
        elevation, azimuth, wavelengths : array_like
            As in `radiance`; wavelengths from 360 to 830 nm.
        frame : {"vertical", "camera"}
            The vertical plane through each direction; or the plane through it and the top of the scene's camera.

        Returns
        -------
        ndarray of float64
            The shape of the directions, followed by a wavelength axis and one of `I`, `Q`, `U`. The values equal those
            of the command `sorairo spectrum --stokes`.

        Raises
        ------
        ValueError
            A direction or a wavelength out of range, a sky with `render.polarisation = "off"`.
        """
        elevations, azimuths = directions_of(elevation, azimuth)
        at = wavelengths_of(wavelengths)
        found = self._sky.stokes(flat(elevations), flat(azimuths), flat(at), text("frame", frame))
        return found.reshape(elevations.shape + at.shape + (3,))

    def between(
        self,
        elevation: ArrayLike,
        azimuth: ArrayLike,
        distance: ArrayLike,
        wavelengths: ArrayLike | None = None,
        *,
        rgb: bool = False,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Transmittance of the air up to a distance, and its in-scattered radiance.

        Light from behind arrives as ``radiance + transmittance * behind``.

        Parameters
        ----------
        elevation, azimuth, distance : array_like
            Directions (degrees, as in `radiance`) and distances from the observer (km; inf for all of the air),
            broadcast against each other. A distance beyond the ground is an error.
        wavelengths : array_like, optional
            At most one axis (nm, 360 to 830).
        rgb : bool
            Returns linear RGB of the scene's space (`render.rgb`) instead of wavelengths, with a final axis of three:
            the radiance in W·m⁻²·sr⁻¹, and the transmittance of sunlight from above the atmosphere.

        Returns
        -------
        transmittance, radiance : ndarray of float64
            The transmittance, and the in-scattered radiance of all orders (W·m⁻²·sr⁻¹·nm⁻¹; sr⁻¹ with the flat sun), in
            the broadcast shape, followed by a wavelength axis. The values equal those of the command `sorairo between`.

        Raises
        ------
        ValueError
            A direction, a distance or a wavelength out of range; wavelengths beside RGB, or neither.
        """
        elevations, azimuths = directions_of(elevation, azimuth)
        elevations, distances = broadcast("elevation", elevations, "distance", distance)
        azimuths = np.broadcast_to(azimuths, elevations.shape)
        if bool(rgb) == (wavelengths is not None):
            raise ValueError("wavelengths are wanted, or rgb=True in their place")
        if wavelengths is None:
            found = self._sky.between_rgb(flat(elevations), flat(azimuths), flat(distances))
            shape = elevations.shape + (3,)
            return found[0].reshape(shape), found[1].reshape(shape)
        at = wavelengths_of(wavelengths)
        found = self._sky.between(flat(elevations), flat(azimuths), flat(distances), flat(at))
        shape = elevations.shape + at.shape
        return found[0].reshape(shape), found[1].reshape(shape)

    def xyz(self, elevation: ArrayLike, azimuth: ArrayLike) -> NDArray[np.float64]:
        """Colour of the sky in directions: X, Y and Z (W·m⁻²·sr⁻¹, weighted by the scene's observer), without the sun's
        disc.

        The fitted radiance from 380 to 780 nm, in means over 5 nm, is summed with the observer's functions. The means
        average the lines of the sun and of user tables, whereas `radiance` has the value at each wavelength. Directions
        are those of `radiance`; the array has their shape, followed by an axis of three.
        """
        elevations, azimuths = directions_of(elevation, azimuth)
        return self._sky.xyz(flat(elevations), flat(azimuths)).reshape((*elevations.shape, 3))

    def luminance(self, elevation: ArrayLike, azimuth: ArrayLike) -> NDArray[np.float64]:
        """Luminance of the sky in directions (cd·m⁻²): 683 lm/W times Y of `xyz`. The array has the shape of the
        directions."""
        return 683.0 * self.xyz(elevation, azimuth)[..., 1]

    def render(
        self, size: tuple[int, int] = (1024, 512), wavelengths: ArrayLike | None = None, device: str = "auto"
    ) -> NDArray[np.float32]:
        """An image of the sky by the scene's camera, by default the whole sphere.

        Parameters
        ----------
        size : (int, int)
            Width and height (pixels, 1 to 8388608 each). Projection, field of view and direction of the camera are keys
            of the scene: `keys={"camera.projection": "fisheye"}`.
        wavelengths : array_like, optional
            One axis (nm, 360 to 830, increasing): the image holds spectral radiance instead of colours.
        device : str
            The device; see `sorairo.device`. A device is opened once and reused.

        Returns
        -------
        ndarray of float32, (height, width, 3) or (height, width, wavelengths)
            Rows from the top. Linear RGB in the scene's space (W·m⁻²·sr⁻¹, weighted by the observer), as in an EXR file
            of the command; or spectral radiance (W·m⁻²·sr⁻¹·nm⁻¹). An equirectangular image has north in its centre and
            east to its right.

        Raises
        ------
        ValueError
            A size or a wavelength out of range, an unknown device.
        RuntimeError
            A device that failed.
        MemoryError
            An image that does not fit into memory.
        """
        width, height = pair("size", size, "width and height in pixels")
        if not all(isinstance(side, (int, np.integer)) and side is not True and 1 <= side <= LONGEST_SIDE for side in (width, height)):
            raise ValueError(f"size is {shown(width)}x{shown(height)}; each side is a whole number of pixels from 1 to {LONGEST_SIDE}")
        at = None
        if wavelengths is not None:
            at = np.atleast_1d(wavelengths_of(wavelengths))
            if np.any(np.diff(at) <= 0):
                raise ValueError("wavelengths of an image must increase from one to the next")
        pixels = self._sky.render((int(width), int(height)), None if at is None else flat(at), text("device", device))
        return pixels.reshape((height, width, 3 if at is None else at.size))

    def irradiance(
        self, wavelengths: ArrayLike, surface_tilt: ArrayLike = 0.0, surface_azimuth: ArrayLike = 180.0
    ) -> dict[str, NDArray[np.float64]]:
        """Spectral irradiance of surfaces at the observer (W·m⁻²·nm⁻¹), by source.

        Parameters
        ----------
        wavelengths : array_like
            At most one axis (nm, 360 to 830; in measured air 280 to 2500).
        surface_tilt : array_like
            Angle between a surface's normal and the zenith (degrees, 0 to 180): 0 is level and faces up, 90 is a wall.
        surface_azimuth : array_like
            Azimuth of a surface's normal (degrees, clockwise from north). Tilts and azimuths are broadcast against each
            other.

        Returns
        -------
        dict of ndarray
            The shape of the surfaces, followed by a wavelength axis. `"direct"`: the visible part of the sun's disc
            (pvlib: `poa_direct`). `"diffuse"`: the upper hemisphere (`poa_sky_diffuse`). `"ground"`: the lower
            hemisphere, the ground and the air in front of it (`poa_ground_diffuse`). `"global"`: their sum
            (`poa_global`).

        Raises
        ------
        ValueError
            A wavelength, a tilt or an azimuth out of range.
        """
        at = wavelengths_of(wavelengths)
        tilts, azimuths = surfaces_of(surface_tilt, surface_azimuth)
        parts = self._sky.irradiance(flat(at), flat(tilts), flat(azimuths))
        return {name: part.reshape(tilts.shape + at.shape) for name, part in zip(PARTS, parts)}

    def illuminance(self, surface_tilt: ArrayLike = 0.0, surface_azimuth: ArrayLike = 180.0) -> dict[str, Any]:
        """Illuminance of surfaces (lx) for the scene's observer, by source: the parts of `irradiance`.

        Floats for one surface, or arrays of the surfaces' shape.
        """
        tilts, azimuths = surfaces_of(surface_tilt, surface_azimuth)
        return _parts(self._sky.illuminance(flat(tilts), flat(azimuths)), tilts)

    def alpha_opic(self, surface_tilt: ArrayLike = 0.0, surface_azimuth: ArrayLike = 180.0) -> dict[str, AlphaOpic]:
        """The five α-opic quantities of CIE S 026:2018 (DOI 10.25039/S026.2018) on surfaces, such as an eye that looks
        along the normal.

        Returns
        -------
        dict of AlphaOpic
            The keys are `"s_cone_opic"`, `"m_cone_opic"`, `"l_cone_opic"`, `"rhodopic"`, `"melanopic"`. Each has an
            `irradiance` (W·m⁻²), the sum of `irradiance` with the standard's action spectrum at 380 to 780 nm by 1 nm,
            and an `edi` (lx), the equivalent illuminance of daylight D65; both by source, as floats for one surface or
            arrays of the surfaces' shape. `sky.alpha_opic(90)["melanopic"].edi["global"]` is the melanopic EDI at an
            eye that looks south.
        """
        tilts, azimuths = surfaces_of(surface_tilt, surface_azimuth)
        found = self._sky.alpha_opic(flat(tilts), flat(azimuths))
        return {name: AlphaOpic(_parts(irradiances, tilts), _parts(daylights, tilts)) for name, irradiances, daylights in found}

    def sun_transmittance(self, wavelengths: ArrayLike) -> NDArray[np.float64]:
        """Transmittance of the sun's beam to the observer (0 to 1), at wavelengths (at most one
        axis; nm, 360 to 830; with a measured `atmosphere.profile`, which has gases, 280 to 2500).

        It is the mean over the sun's disc with limb darkening (Neckel 2005, DOI 10.1007/s11207-005-4081-z), part of
        which the ground may hide: the irradiance of a surface that faces the sun, divided by that above the atmosphere.
        """
        at = wavelengths_of(wavelengths)
        return self._sky.sun_transmittance(flat(at)).reshape(at.shape)

    def to_xarray(
        self,
        elevation: ArrayLike,
        azimuth: ArrayLike,
        wavelengths: ArrayLike,
        method: Method = "fit",
        stokes: bool = False,
    ) -> xarray.Dataset:
        """Radiance over a grid of directions, and the irradiance of level ground, as an `xarray.Dataset` with units and
        CF standard names.

        Parameters
        ----------
        elevation, azimuth, wavelengths : array_like
            One axis each; the dataset has every elevation with every azimuth.
        method : {"fit", "dense"}
            As in `radiance`.
        stokes : bool
            Whether the dataset includes `stokes`: `I`, `Q` and `U` relative to the vertical plane, as in `Sky.stokes`.

        Raises
        ------
        ImportError
            xarray is not installed.
        ValueError
            As `radiance` and `irradiance`.
        """
        from ._labels import labelled

        axes = [np.atleast_1d(doubles(*axis, 1)) for axis in (("elevation", elevation), ("azimuth", azimuth))]
        at = np.atleast_1d(wavelengths_of(wavelengths))
        radiance = self.radiance(axes[0][:, None], axes[1][None, :], at, method)
        vectors = self.stokes(axes[0][:, None], axes[1][None, :], at) if stokes else None
        return labelled((self.sun_elevation, self.sun_azimuth), self.scene, axes, at, radiance, self.irradiance(at), vectors)


def _parts(of_surfaces: list[tuple[float, float, float, float]], like: Doubles) -> dict[str, Any]:
    """The parts of an irradiance: floats, or arrays of a shape."""
    columns = np.array(of_surfaces, dtype=np.float64).reshape(*like.shape, len(PARTS))
    return {name: columns[..., i] if like.shape else float(columns[i]) for i, name in enumerate(PARTS)}
