"""Reads a spectral EXR with the OpenEXR library and with colour-science's reader of its layout.

Usage: spectral_layout.py FILE EXPECTED, where EXPECTED is JSON: the wavelengths, and pixels as column, row and
radiance.
"""

import json
import sys
import warnings

import numpy as np
import OpenEXR

warnings.simplefilter("ignore")
import colour  # noqa: E402  (it warns of packages that this script does not need)

path, expected = sys.argv[1], json.load(open(sys.argv[2]))
wavelengths = expected["wavelengths"]

file = OpenEXR.File(path, separate_channels=True)
header, channels = file.header(), file.channels()
assert header["spectralLayoutVersion"] == "1.0", header
assert header["emissiveUnits"] == "W.m^-2.sr^-1", header
assert "1 nm" in header["emissiveUnitsNote"], header
is_polarised = "stokes" in expected["pixels"][0]
parameters = [f"S{parameter}" for parameter in range(4 if is_polarised else 1)]
names = {of: [f"{of}." + f"{wavelength:.6f}nm".replace(".", ",") for wavelength in wavelengths] for of in parameters}
assert sorted(channels) == sorted(["R", "G", "B", *sum(names.values(), [])]), sorted(channels)
assert len(wavelengths) > 1
stokes = {of: np.stack([channels[name].pixels for name in names[of]], axis=-1) for of in parameters}
spectra = stokes["S0"]
assert spectra.dtype == np.float32 and np.isfinite(spectra).all() and (spectra >= 0).all()

components, specification = colour.read_spectral_image_Fichet2021(path, "float32", additional_data=True)
assert specification.is_emissive and specification.is_polarised == is_polarised and not specification.is_bispectral
assert sorted(components) == parameters, components
for of in parameters:
    read_wavelengths, read_spectra = components[of]
    assert np.array_equal(read_wavelengths, wavelengths), read_wavelengths
    assert np.array_equal(read_spectra, stokes[of])

if is_polarised:
    assert header["polarisationHandedness"] == "right" and "vertical" in header["polarisationFrame"], header
    assert not stokes["S3"].any()
    worst = 0.0
    for pixel in expected["pixels"]:
        i, q, u = np.array(pixel["stokes"]).T
        degree = np.hypot(q, u).max() / i.max()
        assert degree > 0.02, pixel
        for of, value in (("S1", q), ("S2", u)):
            worst = max(worst, np.abs(stokes[of][pixel["row"], pixel["column"]] / spectra[pixel["row"], pixel["column"]] - value / i).max())
    assert worst < expected["bound"], worst
    print(f"polarisation against sorairo spectrum --stokes: {worst:.1e}")
    sys.exit()

worst = 0.0
for pixel in expected["pixels"]:
    radiance = np.array(pixel["radiance"])
    assert (radiance > 0).all(), pixel
    error = np.abs(spectra[pixel["row"], pixel["column"]] / radiance - 1).max()
    assert error < 1e-3, (pixel, error)
    worst = max(worst, error)
assert len(expected["pixels"]) > 1
print(f"radiance against sorairo spectrum: {worst:.1e}")

# The preview is the colour of the spectrum: the luminance of both, the spectrum summed every 5 nm.
observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(colour.SpectralShape(380, 780, 5))
assert np.array_equal(wavelengths, observer.wavelengths)
from_spectrum = spectra @ observer.values[:, 1] * 5
from_preview = sum(channels[name].pixels * weight for name, weight in zip("RGB", (0.2126, 0.7152, 0.0722)))
# In twilight four bands hold the luminance of measured air within 1.2 %, and of the sun's lines the values every 5 nm
# make 0.35 % more than the means over 5 nm that the preview takes.
lit = from_preview > 1e-3 * from_preview.max()
error = np.abs(from_spectrum[lit] / from_preview[lit] - 1).max()
assert lit.sum() > 100 and error < 1.6e-2, error
print(f"luminance of the spectrum against the preview: {error:.1e}")
