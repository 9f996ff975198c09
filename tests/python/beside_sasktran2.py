"""Compares sorairo and SASKTRAN2 with a Monte Carlo reference of the light of all orders of scattering.

Usage: beside_sasktran2.py --program SORAIRO --reference CSV --ozone CSV --out JSON [--threads N] [--methods NAME...]

The command sorairo answers the same rows: it is one of the methods. Times are of a hemisphere of directions at four
wavelengths; of sorairo they are those that its report states for the plan and the kernels on the processor, with as
many threads as there are.

The reference's columns are those of its header; the ozone table has rows of wavelength (nm) and absorption
cross-section (m2).
"""

import argparse
import csv
import json
import math
import statistics
import subprocess
import tempfile
import time
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from datetime import date
from functools import partial
from importlib.metadata import version
from multiprocessing import get_context

import numpy as np
import sasktran2 as sk

METRES_PER_KM = 1000.0
DOBSON_UNIT = 2.687e20  # molecules per m2


@dataclass(frozen=True)
class Atmosphere:
    """What the reference calls `earth`: the renderer's preset of that name."""

    ground_radius: float = 6360.0  # km
    height: float = 100.0  # km
    # Bruneton and Neyret 2008: scattering at the ground and 1 um (km-1), as the fourth power of the wavelength; a phase
    # function of 3/4 (1 + cos2), without depolarisation.
    air_scattering: float = 1.24062e-3
    air_scale_height: float = 8.0  # km
    # Extinction at the ground times scale height at 1 um; Angstrom's law; Cornette and Shanks's phase function.
    aerosol_optical_depth: float = 5.328e-3
    angstrom_exponent: float = 0.0
    aerosol_scale_height: float = 1.2  # km
    single_scattering_albedo: float = 0.9
    asymmetry: float = 0.8
    # A tent: densest at its peak, none under its bottom and over its top (km).
    ozone_column: float = 300.0  # Dobson units
    ozone_bottom: float = 10.0
    ozone_peak: float = 25.0
    ozone_top: float = 40.0


EARTH = Atmosphere()
# As the reference's header describes them.
ATMOSPHERES = {
    "earth": EARTH,
    "turbid": replace(EARTH, aerosol_optical_depth=0.04, angstrom_exponent=0.8, single_scattering_albedo=0.8, asymmetry=0.7),
    "very_turbid": replace(EARTH, aerosol_optical_depth=0.3, single_scattering_albedo=0.95, asymmetry=0.75),
}


def grown(first, ratio, thickest):
    """Altitudes (km) of levels: thin layers at the ground, where aerosol is."""
    levels, layer = [0.0], first
    while levels[-1] < EARTH.height:
        levels.append(levels[-1] + min(layer, thickest))
        layer *= ratio
    return np.array(levels) * EARTH.height / levels[-1]


def stacked(*parts):
    """Altitudes (km) at even spacing in each of some (start, end, spacing)."""
    return np.concatenate([np.arange(*part) for part in parts])


# Successive orders lose up to 7 % of the multiply scattered light where one layer is much thinner than the next: even
# layers up to the top of the ozone. Its sources may stand further apart than the levels.
EVEN = stacked((0.0, 40.0, 0.5), (40.0, 100.1, 2.0))
SOURCES = stacked((0.5, 10.0, 1.0), (11.0, 40.0, 2.0), (44.0, 100.0, 8.0))


@dataclass(frozen=True)
class Method:
    """A choice of solver: the name of its `MultipleScatterSource`, altitudes of levels (km), and what else is set of
    its `Config`."""

    source: str
    levels: np.ndarray
    options: dict

    def config(self, threads):
        config = sk.Config()
        config.num_threads = threads
        # A few wavelengths only.
        config.threading_model = sk.ThreadingModel.Source
        config.log_level = sk.LogLevel.Error
        config.single_scatter_source = sk.SingleScatterSource.Exact
        config.multiple_scatter_source = getattr(sk.MultipleScatterSource, self.source)
        # Of aerosol with an asymmetry of 0.8 nothing is left after so many.
        config.num_singlescatter_moments = 128
        for name, value in self.options.items():
            setattr(config, name, value)
        return config

    def described(self):
        options = {name: value for name, value in self.options.items() if not name.endswith("_grid_m")}
        return {"multiple_scatter_source": self.source, "levels": len(self.levels), **options}


def ordinates(streams, columns, levels):
    return Method("DiscreteOrdinates", levels, {"num_streams": streams, "num_sza": columns})


def orders(incoming, outgoing, columns):
    options = {
        "num_successive_orders_incoming": incoming,
        "num_successive_orders_outgoing": outgoing,
        "num_sza": columns,
        "successive_orders_altitude_grid_m": (SOURCES * METRES_PER_KM).tolist(),
    }
    return Method("SuccessiveOrders", EVEN, options)


OURS = "sorairo"
# Against the reference's light of one order: whether both mean the same air.
CHECK = "single scattering"
METHODS = {
    CHECK: Method("NoSource", grown(0.05, 1.03, 2.0), {}),
    "discrete ordinates, fast": ordinates(8, 5, grown(0.25, 1.04, 3.0)),
    "discrete ordinates, best": ordinates(16, 21, grown(0.25, 1.04, 3.0)),
    "successive orders, fast": orders(50, 50, 3),
    "successive orders, best": orders(110, 194, 5),
}


def cornette_shanks_moments(asymmetry, count):
    """Legendre coefficients of the aerosol's phase function, of which the first is 1."""
    g = asymmetry
    nu, weights = np.polynomial.legendre.leggauss(2 * count + 100)
    phase = 1.5 * (1 - g * g) * (1 + nu * nu) / ((2 + g * g) * (1 + g * g - 2 * g * nu) ** 1.5)
    return (2 * np.arange(count) + 1) / 2 * (np.polynomial.legendre.legvander(nu, count - 1).T @ (weights * phase))


def medium(atmosphere, ozone, altitudes, wavelengths, count):
    """Extinction, single-scattering albedo and phase function at each altitude (km) and wavelength (nm)."""
    a, z, micrometres = atmosphere, altitudes, wavelengths / 1000
    air = np.outer(np.exp(-z / a.air_scale_height), a.air_scattering * micrometres**-4)
    extinction_at_ground = a.aerosol_optical_depth / a.aerosol_scale_height * micrometres**-a.angstrom_exponent
    aerosol = np.outer(np.exp(-z / a.aerosol_scale_height), extinction_at_ground)
    tent = np.interp(z, [a.ozone_bottom, a.ozone_peak, a.ozone_top], [0.0, 1.0, 0.0])
    # A tent holds half its base times its height.
    peak_per_km = a.ozone_column * DOBSON_UNIT / ((a.ozone_top - a.ozone_bottom) / 2)
    absorption = np.outer(tent, peak_per_km * np.interp(wavelengths, *ozone))
    by_aerosol = a.single_scattering_albedo * aerosol
    scattering, extinction = air + by_aerosol, air + aerosol + absorption
    rayleigh = np.zeros(count)
    rayleigh[[0, 2]] = 1.0, 0.5
    moments = np.multiply.outer(rayleigh, air) + np.multiply.outer(cornette_shanks_moments(a.asymmetry, count), by_aerosol)
    return sk.constituent.Manual(extinction / METRES_PER_KM, scattering / extinction, moments / scattering)


@dataclass(frozen=True)
class Sky:
    """All rows of a sky are seen by one observer, under one sun."""

    case: str
    albedo: float
    altitude: float  # km
    sun: float  # degrees


def ray(sky, elevation, azimuth):
    # On the ground itself a ray may begin under it.
    altitude = max(sky.altitude * METRES_PER_KM, 1.0)
    sun, view = (math.sin(math.radians(angle)) for angle in (sky.sun, elevation))
    return sk.SolarAnglesObserverLocation(sun, math.radians(azimuth), view, altitude)


def radiance(method, ozone, threads, sky, wavelengths, directions):
    """Radiance (sr-1) by wavelength (nm) and direction (degrees)."""
    atmosphere, config, altitudes = ATMOSPHERES[sky.case], method.config(threads), method.levels
    sun = math.sin(math.radians(sky.sun))
    geometry = sk.Geometry1D(sun, 0.0, atmosphere.ground_radius * METRES_PER_KM, altitudes * METRES_PER_KM)
    viewing = sk.ViewingGeometry()
    for direction in directions:
        viewing.add_ray(ray(sky, *direction))
    # Columns with suns of their own stand only along the rays: one along the horizon towards the sun brings those from
    # which the light of a low sun comes. Without it, columns for vertical rays alone crash the solver; one away from
    # the sun would bring night, in which successive orders diverge at some settings. What they leave out of it makes
    # their twilight too bright.
    horizon = -math.degrees(math.acos(atmosphere.ground_radius / (atmosphere.ground_radius + sky.altitude)))
    viewing.add_ray(ray(sky, horizon + 0.3, 0.0))
    wavelengths = np.array(wavelengths, dtype=float)
    air = sk.Atmosphere(geometry, config, wavelengths_nm=wavelengths, calculate_derivatives=False)
    air["medium"] = medium(atmosphere, ozone, altitudes, wavelengths, config.num_singlescatter_moments)
    air["ground"] = sk.constituent.LambertianSurface(sky.albedo)
    found = sk.Engine(config, geometry, viewing).calculate_radiance(air)["radiance"]
    return found.values[:, : len(directions), 0]


def scene_file(folder, sky, rest=""):
    """The scene of a sky for sorairo, with a sun of 1 in the north."""
    atmosphere = ATMOSPHERES[sky.case]
    path = f"{folder}/scene.toml"
    with open(path, "w") as file:
        file.write(
            f"""preset = "earth"
sun = {{ elevation = {sky.sun}, azimuth = 0, spectrum = "flat" }}
observer.altitude = {sky.altitude}
ground.albedo = {sky.albedo}
[atmosphere.aerosol]
optical_depth = {atmosphere.aerosol_optical_depth}
angstrom_exponent = {atmosphere.angstrom_exponent}
single_scattering_albedo = {atmosphere.single_scattering_albedo}
asymmetry = {atmosphere.asymmetry}
[render]
orders = "all"
{rest}"""
        )
    return path


def radiance_by_sorairo(program, sky, wavelengths, directions):
    """As `radiance`, by the command, which integrates each wavelength."""
    with tempfile.TemporaryDirectory() as folder:
        scene = scene_file(folder, sky)
        found = np.empty((len(wavelengths), len(directions)))
        for i, (elevation, azimuth) in enumerate(directions):
            listed = ",".join(map(str, wavelengths))
            command = [program, "spectrum", "--scene", scene, f"--view-elevation={elevation}", f"--view-azimuth={azimuth}"]
            done = subprocess.run([*command, "--wavelengths", listed, "--format", "json"], check=True, capture_output=True)
            found[:, i] = [sample["dense"] for sample in json.loads(done.stdout)]
        return found


def seconds_of_sorairo(program, sky, repetitions=5):
    """Plan and kernels of 144 directions above the horizon at four wavelengths."""
    rest = f"""fit = "dense"
bands = {TIMED_WAVELENGTHS}
path = "direct"
[camera]
size = "24x12"
"""
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        scene = scene_file(folder, sky, rest)
        for _ in range(1 + repetitions):
            command = [program, "render", "--scene", scene, "--device", "cpu", "--json", "-o", f"{folder}/sky.exr"]
            report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
            seconds.append((report["plan_ms"] + report["kernel_ms"]) / 1000)
    return statistics.median(seconds[1:])


def apart(function, *arguments):
    """What a function returns in a process of its own, which the solver may abort."""
    with ProcessPoolExecutor(1, mp_context=get_context("fork")) as pool:
        return pool.submit(function, *arguments).result()


def read_reference(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return [{name: value if name == "case" else float(value) for name, value in row.items()} for row in rows]


def read_ozone(path):
    return np.loadtxt(path, delimiter=",", comments="#", unpack=True)


def skies_of(rows):
    skies = defaultdict(list)
    for row in rows:
        skies[Sky(row["case"], row["albedo"], row["altitude_km"], row["sun_elevation"])].append(row)
    return skies


# Suns (degrees), and a sky full of aerosol.
GROUPS = ["10 to 90", "0 to 10", "-6 to 0", "-12 to -6", "haze"]


def group(row):
    if row["case"] == "very_turbid":
        return "haze"
    bounds = [(10, "10 to 90"), (0, "0 to 10"), (-6, "-6 to 0")]
    return next((name for sun, name in bounds if row["sun_elevation"] >= sun), "-12 to -6")


def compare(name, solve, rows):
    """Errors of a method by group of suns, and the rows that it could not compute."""
    is_check = name == CHECK
    column = "single" if is_check else "total"
    errors, missing = defaultdict(list), []
    for sky, of_sky in skies_of(rows).items():
        wavelengths = sorted({row["wavelength_nm"] for row in of_sky})
        directions = sorted({(row["view_elevation"], row["relative_azimuth"]) for row in of_sky})
        lit = replace(sky, albedo=0.0) if is_check else sky
        try:
            found, problem = solve(lit, wavelengths, directions), None
        except (BrokenProcessPool, RuntimeError, ValueError) as error:
            found, problem = None, f"{type(error).__name__}: {error}"
        for row in of_sky:
            known = row[column]
            if found is not None:
                at = wavelengths.index(row["wavelength_nm"]), directions.index((row["view_elevation"], row["relative_azimuth"]))
                value = float(found[at])
                # These skies are all fainter than 1: more, or less than nothing, is an iteration that diverged.
                problem = None if 0 <= value < 1 else f"radiance of {value:.3g}"
            if problem:
                missing.append({**row, "problem": problem})
                continue
            brightest = max(other[column] for other in of_sky if other["wavelength_nm"] == row["wavelength_nm"])
            scale = max(known, 0.05 * brightest)
            if scale == 0:
                # One order sends nothing from air in the planet's shadow.
                continue
            difference = abs(value - known)
            chance = 0.0 if is_check else 2 * row["stderr_total"]
            errors[group(row)].append((difference / scale, max(difference - chance, 0) / scale, (value - known) / scale))
    groups = [{"suns": name, **summary(errors[name])} for name in GROUPS if name in errors]
    return {"groups": groups, "not_computed": missing}


def summary(errors):
    plain, beyond_chance, signed = zip(*errors)
    rms = lambda values: math.sqrt(statistics.fmean(value * value for value in values))
    return {
        "rows": len(plain),
        "largest": max(plain),
        "rms": rms(plain),
        "largest_beyond_2_standard_errors": max(beyond_chance),
        "rms_beyond_2_standard_errors": rms(beyond_chance),
        "mean_signed": statistics.fmean(signed),
    }


def tregenza():
    """The 145 patches of a sky (Tregenza 1987): elevation and azimuth (degrees)."""
    rows = [(6, 30), (18, 30), (30, 24), (42, 24), (54, 18), (66, 12), (78, 6), (90, 1)]
    return [(elevation, 360 * i / count) for elevation, count in rows for i in range(count)]


def median_seconds(method, ozone, threads, sky, directions, repetitions=5):
    """Geometry, optical properties and solution, each time anew."""
    seconds = []
    for _ in range(1 + repetitions):
        start = time.perf_counter()
        radiance(method, ozone, threads, sky, TIMED_WAVELENGTHS, directions)
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds[1:])


TIMED_WAVELENGTHS = [450, 520, 590, 660]  # nm


def timings(seconds):
    """Those of a function of a sky, for three suns."""
    timed = []
    for sun in (45.0, 10.0, 2.0):
        sky = Sky("earth", 0.3, 0.0, sun)
        timed.append({"sun_elevation": sun, "wavelengths_nm": TIMED_WAVELENGTHS, "seconds": seconds(sky)})
    return timed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", required=True, help="the command sorairo")
    parser.add_argument("--reference", required=True, help="the Monte Carlo reference (CSV)")
    parser.add_argument("--ozone", required=True, help="absorption cross-section of ozone (CSV of nm and m2)")
    parser.add_argument("--out", required=True, help="where the report goes (JSON)")
    parser.add_argument("--threads", type=int, default=2, help="threads of the solver")
    names = [OURS, *METHODS]
    parser.add_argument("--methods", nargs="+", choices=names, default=names, metavar="NAME", help="some of: " + "; ".join(names))
    arguments = parser.parse_args()
    rows, ozone, threads = read_reference(arguments.reference), read_ozone(arguments.ozone), arguments.threads
    report = {"sasktran2": version("sasktran2"), "threads": threads, "date": date.today().isoformat(), "methods": []}
    for name in arguments.methods:
        if name == OURS:
            options = {}
            solve = partial(radiance_by_sorairo, arguments.program)
            seconds = partial(seconds_of_sorairo, arguments.program)
        else:
            method = METHODS[name]
            options = method.described()
            solve = partial(apart, radiance, method, ozone, threads)
            seconds = lambda sky: apart(median_seconds, method, ozone, threads, sky, tregenza())
        outcome = compare(name, solve, rows)
        outcome["timings"] = timings(seconds)
        report["methods"].append({"name": name, "options": options, **outcome})
        print(f"{name}: {len(outcome['not_computed'])} rows not computed")
        for found in outcome["groups"]:
            largest, rms = (100 * found[f"{kind}_beyond_2_standard_errors"] for kind in ("largest", "rms"))
            print(f"  {found['suns']}: {found['rows']} rows, {largest:.2f} % largest, {rms:.3f} % rms")
        for timed in outcome["timings"]:
            print(f"  sun at {timed['sun_elevation']:.0f}: {timed['seconds']:.4f} s", flush=True)
        with open(arguments.out, "w") as file:
            json.dump(report, file, indent=1)
            file.write("\n")


if __name__ == "__main__":
    main()
