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
names = [f"S0.{wavelength:.6f}nm".replace(".", ",").replace("S0,", "S0.") for wavelength in wavelengths]
assert sorted(channels) == sorted(["R", "G", "B", *names]), sorted(channels)
assert len(wavelengths) > 1
spectra = np.stack([channels[name].pixels for name in names], axis=-1)
assert spectra.dtype == np.float32 and np.isfinite(spectra).all() and (spectra >= 0).all()

components, specification = colour.read_spectral_image_Fichet2021(path, "float32", additional_data=True)
assert specification.is_emissive and not specification.is_polarised and not specification.is_bispectral
assert list(components) == ["S0"], components
read_wavelengths, read_spectra = components["S0"]
assert np.array_equal(read_wavelengths, wavelengths), read_wavelengths
assert np.array_equal(read_spectra, spectra)

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
