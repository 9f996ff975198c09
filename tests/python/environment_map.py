"""Lights a white plane by a sky in Mitsuba 3, and looks for the sun in it.

Usage: environment_map.py IMAGE REPORT ELEVATION AZIMUTH: the image, what `sorairo render --json` said of it, and the
sun (degrees).
"""

import json
import sys

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

image, report = sys.argv[1], json.load(open(sys.argv[2]))
elevation, azimuth = map(float, sys.argv[3:])


def direction(elevation, azimuth):
    """The unit vector of a bearing: x north, y west, z up, azimuth clockwise from north."""
    e, a = np.radians(elevation), np.radians(azimuth)
    return np.array([np.cos(e) * np.cos(a), -np.cos(e) * np.sin(a), np.sin(e)])


# As in docs/environment-maps.md.
sky = {"type": "envmap", "filename": image, "to_world": mi.ScalarTransform4f([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])}


def irradiance():
    """Irradiance of a level white plane: π times the radiance that it reflects."""
    above = mi.ScalarTransform4f().look_at(origin=[0, 0, 1], target=[0, 0, 0], up=[1, 0, 0]).scale([0.1, 0.1, 1])
    film = {"type": "hdrfilm", "width": 8, "height": 8, "pixel_format": "rgb", "component_format": "float32"}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct"},
            "sky": sky,
            "ground": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}},
            "sensor": {"type": "orthographic", "to_world": above, "film": film, "sampler": {"type": "independent"}},
        }
    )
    return np.pi * np.array(mi.render(scene, spp=2048, seed=1)).mean(axis=(0, 1))


measured, said = irradiance(), np.array(report["irradiance_rgb"])
error = np.abs(measured / said - 1).max()
print(f"irradiance {measured} W/m2, sorairo says {said}: {error:.1e}")
assert error < 0.01, error
illuminance = 683 * measured @ [0.2126, 0.7152, 0.0722]
error = abs(illuminance / report["illuminance_lux"] - 1)
print(f"illuminance {illuminance:.0f} lx, sorairo says {report['illuminance_lux']:.0f}: {error:.1e}")
assert error < 0.01, error


def radiance(emitter, view):
    interaction = dr.zeros(mi.SurfaceInteraction3f)
    interaction.wi = mi.Vector3f(*-view)
    return np.array(emitter.eval(interaction)).max()


def brightest(emitter):
    """Elevation and azimuth of the brightest direction above 10 degrees, on a grid of 1 degree."""
    bearings = [(e, a) for e in range(10, 90) for a in range(360)]
    return max(bearings, key=lambda bearing: radiance(emitter, direction(*bearing)))


def apart(a, b):
    return np.degrees(np.arccos(np.clip(direction(*a) @ direction(*b), -1, 1)))


ours = mi.load_dict(sky)
up, down = (np.mean([radiance(ours, direction(e, a)) for a in range(0, 360, 5)]) for e in (45, -45))
print(f"radiance 45 degrees above the horizon {up:.3g}, below {down:.3g}")
# The ground is lit by the same sky: grass sends back a part of it.
assert 0 < down < 0.3 * up

# Mitsuba's own sky with its sun, whose disc is its brightest place.
theirs = mi.load_dict(
    {"type": "sunsky", "sun_direction": list(direction(elevation, azimuth)), "turbidity": 8.0}
)
sun, glow, other = (elevation, azimuth), brightest(ours), brightest(theirs)
print(f"the sun stands at {sun}; sorairo's sky is brightest at {glow}, Mitsuba's at {other}")
# The grid's degree, and one of the glow's own slope.
assert apart(glow, sun) < 2 and apart(other, sun) < 1 and apart(glow, other) < 2
