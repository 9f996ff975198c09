"""Many suns in one call."""

from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
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


def test_what_differs_from_sun_to_sun_is_that_of_its_sky():
    suns, at = [40.0, 20.0, 5.0], [400, 550, 700]
    tilts, azimuths = [10.0, 45.0, 80.0], [90.0, 180.0, 270.0]
    albedos, depths, pressures = [0.1, 0.3, 0.6], [0.05, 0.2, 0.4], [1013.0, 950.0, 700.0]
    found = sorairo.sequence(
        sun_elevation=suns,
        sun_azimuth=120,
        wavelengths=at,
        elevation=30,
        azimuth=[0, 90],
        albedo=np.array(albedos),
        surface_tilt=tilts,
        surface_azimuth=azimuths,
        keys={"atmosphere.aerosol.optical_depth": depths, "atmosphere.air.pressure": pressures, "atmosphere.ozone.column": 320},
    )
    for i, sun in enumerate(suns):
        keys = {"atmosphere.aerosol.optical_depth": depths[i], "atmosphere.air.pressure": pressures[i], "atmosphere.ozone.column": 320}
        sky = sorairo.Sky(sun_elevation=sun, sun_azimuth=120, albedo=albedos[i], keys=keys)
        assert np.array_equal(found.radiance[i], sky.radiance(30, [0, 90], at))
        one = sky.irradiance(at, tilts[i], azimuths[i])
        assert all(np.array_equal(found.irradiance[name][i], one[name]) for name in one)


def test_one_sun_is_broadcast_against_what_has_an_axis():
    found = sorairo.sequence(sun_elevation=30, wavelengths=550, surface_tilt=[0, 45, 90], albedo=["grass", "snow", "sea"])
    assert found.irradiance["global"].shape == (3,) and list(found.sun_elevation) == [30] * 3
    snow = sorairo.Sky(sun_elevation=30, albedo="snow").irradiance(550, 45)
    assert found.irradiance["global"][1] == snow["global"]


@pytest.mark.parametrize("offset", [timedelta(hours=9, minutes=18, seconds=59), -timedelta(minutes=25, seconds=21), timedelta(microseconds=7)])
def test_a_time_of_a_zone_with_seconds_is_the_moment_that_it_is(offset):
    there = datetime(1880, 6, 21, 12, 0, 0, 250_000, tzinfo=timezone(offset))
    utc = there.astimezone(timezone.utc)
    skies = [sorairo.Sky(place=(35.7, 139.7), time=time) for time in (there, utc)]
    assert (skies[0].sun_elevation, skies[0].sun_azimuth) == (skies[1].sun_elevation, skies[1].sun_azimuth)
    found = sorairo.sequence(place=(35.7, 139.7), time=[there], wavelengths=550, surface_tilt=0)
    assert found.sun_elevation[0] == skies[1].sun_elevation


def test_a_row_of_even_steps_may_end_a_rounding_beyond_its_end():
    suns = np.arange(-20, 90.01, 0.05)
    assert suns[-1] > 90
    assert sorairo.Sky(sun_elevation=suns[-1]).sun_elevation == 90
    found = sorairo.sequence(sun_elevation=suns[-2:], wavelengths=550, surface_tilt=0)
    assert found.sun_elevation[-1] == 90
    poles = [sorairo.Sky(place=(latitude, 0), time="2026-06-21T04:30Z") for latitude in (suns[-1], 90)]
    assert poles[0].sun_elevation == poles[1].sun_elevation
    sky = sorairo.Sky("earth", sun_elevation=30)
    wavelengths = np.arange(360, 830.01, 0.1)
    assert wavelengths[-1] > 830
    assert np.array_equal(sky.radiance(suns[-1], 0, wavelengths[-2:]), sky.radiance(90, 0, [wavelengths[-2], 830]))
    assert np.array_equal(sky.sun_transmittance(wavelengths[-1:]), sky.sun_transmittance([830]))
    assert sky.render((4, 2), wavelengths[-2:], device="cpu").any()
    assert sky.irradiance(wavelengths[-1], 180 + 1e-10, -360 - 1e-10)["global"] == sky.irradiance(830, 180, -360)["global"]
