"""Many suns in one call."""

from datetime import datetime, timedelta, timezone

import numpy as np
import sorairo


def test_a_sequence_has_the_numbers_of_its_skies():
    suns, at, azimuths = [30.0, 5.0, -3.0], [400, 550, 700], np.arange(0, 360, 45)
    found = sorairo.sequence(
        "hazy", sun_elevation=suns, sun_azimuth=90, wavelengths=at, elevation=20, azimuth=azimuths, surface_tilt=30
    )
    assert found.radiance.shape == (3, 8, 3) and found.irradiance["global"].shape == (3, 3)
    assert list(found.sun_elevation) == suns and list(found.sun_azimuth) == [90] * 3
    for i, sun in enumerate(suns):
        sky = sorairo.Sky("hazy", sun_elevation=sun, sun_azimuth=90)
        assert np.array_equal(found.radiance[i], sky.radiance(20, azimuths, at))
        one = sky.irradiance(at, surface_tilt=30)
        assert all(np.array_equal(found.irradiance[name][i], one[name]) for name in one)


def test_a_sequence_follows_a_day():
    noon = datetime(2026, 6, 21, 12, tzinfo=timezone(timedelta(hours=9)))
    times = [noon + timedelta(hours=hour) for hour in (-3, 0, 3)]
    found = sorairo.sequence(place=(43.06, 141.35), time=times, wavelengths=550, surface_tilt=0)
    assert found.radiance is None
    expected = sorairo.Sky(place=(43.06, 141.35), time=times[0])
    assert found.sun_elevation[0] == expected.sun_elevation and found.sun_azimuth[0] == expected.sun_azimuth
    irradiance = found.irradiance["global"]
    assert irradiance.shape == (3,) and irradiance[1] == irradiance.max()
