use std::f64::consts::PI;

use super::*;
use crate::line::{Line, dot, entry_distance, half_chord};
use crate::quadrature::GaussLegendre;
use crate::single::ViewPath;
use crate::way::{Shells, Way};

const EARTH: Medium = Medium {
    ground_radius_km: 6360.0,
    top_radius_km: 6460.0,
    air_scale_height_km: 8.0,
    aerosol_scale_height_km: 1.2,
    aerosol_asymmetry: 0.8,
    ozone_bottom_km: 10.0,
    ozone_peak_km: 25.0,
    ozone_top_km: 40.0,
    levels: &[],
};

/// Violet, where air is thickest; orange, where ozone is; and orange through heavy haze.
const BANDS: [Coefficients; 3] = [
    Coefficients {
        air_scattering: 4.8e-2,
        air_depolarisation: 0.0,
        aerosol_extinction: 4.44e-3,
        aerosol_scattering: 4.0e-3,
        ozone_absorption: 1e-5,
        gas_absorption: [0.0; 2],
        ground_albedo: 0.0,
        aerosol_phase: None,
    },
    Coefficients {
        air_scattering: 9.0e-3,
        air_depolarisation: 0.0,
        aerosol_extinction: 4.44e-3,
        aerosol_scattering: 4.0e-3,
        ozone_absorption: 2.6e-3,
        gas_absorption: [0.0; 2],
        ground_albedo: 0.0,
        aerosol_phase: None,
    },
    Coefficients {
        air_scattering: 9.0e-3,
        air_depolarisation: 0.0,
        aerosol_extinction: 4.44e-2,
        aerosol_scattering: 4.0e-2,
        ozone_absorption: 2.6e-3,
        gas_absorption: [0.0; 2],
        ground_albedo: 0.0,
        aerosol_phase: None,
    },
];

const ONLY_AIR: Coefficients = Coefficients {
    air_scattering: 0.05,
    air_depolarisation: 0.0,
    aerosol_extinction: 0.0,
    aerosol_scattering: 0.0,
    ozone_absorption: 0.0,
    gas_absorption: [0.0; 2],
    ground_albedo: 0.0,
    aerosol_phase: None,
};

fn ray(observer_altitude_km: f64, view: [f64; 3], sun: [f64; 3]) -> Ray {
    Ray { observer_altitude_km, view, sun }
}

/// Rays from the ground to beyond the atmosphere, night to noon, ground to zenith.
fn rays() -> Vec<Ray> {
    let mut rays = Vec::new();
    for altitude in [0.0, 0.5, 12.0, 60.0, 400.0, 36000.0] {
        for sun in [-9.0, -4.0, 0.0, 2.0, 45.0] {
            for view in [-89.9, -20.0, -7.2, -2.1, 0.0, 0.3, 10.0, 90.0] {
                for azimuth in [0.01, 90.0, 180.0] {
                    rays.push(ray(altitude, direction(view, azimuth), direction(sun, 0.0)));
                }
            }
        }
    }
    rays
}

#[track_caller]
fn assert_close(actual: f64, expected: f64, tolerance: f64) {
    let close = (actual - expected).abs() <= tolerance * expected.abs();
    assert!(close, "{actual:e} is not {expected:e} within {tolerance:e}");
}

/// Simpson's rule with 20000 steps: 5e-3 km where the integrand changes over 1 km, so exact to
/// 1e-11.
fn simpson(start: f64, end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let steps = 20000;
    let step = (end - start) / steps as f64;
    let weight = |i| match i {
        0 => 1.0,
        i if i == steps => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..=steps).map(|i| weight(i) * f(start + i as f64 * step)).sum::<f64>() * step / 3.0
}

/// A column by Simpson's rule, between the corners of the ozone profile, in distance from the
/// perigee.
fn column_by_simpson(medium: &Medium, altitude: f64, mu: f64) -> [f64; 3] {
    let radius = medium.ground_radius_km + altitude;
    let perigee = radius * (1.0 - mu * mu).sqrt();
    let start = radius * mu;
    let end = half_chord(medium.top_radius_km, perigee);
    let mut cuts = vec![start, end];
    for kink in medium.kinks_km() {
        let chord = half_chord(medium.ground_radius_km + kink, perigee);
        cuts.extend([-chord, chord].into_iter().filter(|t| *t > start && *t < end));
    }
    cuts.sort_by(f64::total_cmp);
    let density = |t: f64| medium.densities(perigee.hypot(t) - medium.ground_radius_km);
    std::array::from_fn(|i| cuts.windows(2).map(|ends| simpson(ends[0], ends[1], |t| density(t)[i])).sum())
}

/// The definition, in vectors, with uniform steps and no thought.
fn radiance_by_brute_force(medium: &Medium, band: &Coefficients, ray: &Ray, length: f64) -> f64 {
    let steps = 3000;
    let step = length / steps as f64;
    let nu = dot(ray.view, ray.sun);
    let along = |p: [f64; 3], v: [f64; 3], s: f64| [0, 1, 2].map(|i| p[i] + s * v[i]);
    let altitude = |p: [f64; 3]| dot(p, p).sqrt() - medium.ground_radius_km;
    let observer = [0.0, 0.0, medium.ground_radius_km + ray.observer_altitude_km];
    let depth_to_sun = |p: [f64; 3]| {
        let b = dot(p, ray.sun);
        let distance = -b + (b * b + medium.top_radius_km.powi(2) - dot(p, p)).sqrt();
        let step = distance / 1000.0;
        let mut depth = 0.0;
        for j in 0..1000 {
            let height = altitude(along(p, ray.sun, (j as f64 + 0.5) * step));
            if height < 0.0 {
                return f64::INFINITY;
            }
            depth += step * band.optical_depth(medium.densities(height));
        }
        depth
    };
    let (mut depth, mut radiance) = (0.0, 0.0);
    for i in 0..steps {
        let p = along(observer, ray.view, (i as f64 + 0.5) * step);
        let density = medium.densities(altitude(p));
        let half = 0.5 * step * band.optical_depth(density);
        let scattered = density[0] * band.air_scattering * air_phase(0.0, nu)
            + density[1] * band.aerosol_scattering * aerosol_phase(medium.aerosol_asymmetry, nu);
        radiance += step * scattered * (-(depth + half) - depth_to_sun(p)).exp();
        depth += 2.0 * half;
    }
    radiance
}

#[test]
fn azimuth_reads_like_a_compass() {
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
    assert!(near(direction(0.0, 0.0), [1.0, 0.0, 0.0]), "north is x");
    assert!(near(direction(0.0, 90.0), [0.0, -1.0, 0.0]), "east is -y");
    assert!(near(direction(0.0, 270.0), [0.0, 1.0, 0.0]), "west is y");
    assert!(near(direction(90.0, 12.0), [0.0, 0.0, 1.0]), "up is z");
}

#[test]
fn phase_functions_integrate_to_one() {
    let rule = GaussLegendre::<64>::new();
    let sphere = |phase: &dyn Fn(f64) -> f64| 2.0 * PI * rule.integrate(-1.0, 1.0, phase);
    assert_close(sphere(&|nu| air_phase(0.0, nu)), 1.0, 1e-14);
    for asymmetry in [-0.5, 0.0, 0.3, 0.8] {
        // Poles of the phase function at ν = (1 + g²) / 2g: 64 nodes give 1e-12 for g = 0.8.
        assert_close(sphere(&|nu| aerosol_phase(asymmetry, nu)), 1.0, 1e-11);
    }
}

#[test]
fn air_that_depolarises_scatters_more_evenly() {
    // Chandrasekhar's ratio of across to along, (1 + ρ) / 2.
    for depolarisation in [0.0, 0.0279, 1.0] {
        let across = air_phase(depolarisation, 0.0) / air_phase(depolarisation, 1.0);
        assert_close(across, (1.0 + depolarisation) / 2.0, 1e-15);
    }
}

#[test]
fn measured_air_scatters_as_it_is_published() {
    // Bodhaine et al. 1999, Eq. 29, which gives their own computation from 0.25 to 0.85 µm within 0.01 %.
    let published = |nm: f64| {
        let square = (nm / 1000.0).powi(2);
        (1.045_599_6 - 341.290_61 / square - 0.902_308_50 * square)
            / (1.0 + 0.002_705_988_9 / square - 85.968_563 * square)
    };
    let relative = |of: &dyn Fn(f64) -> f64, nm: f64| of(nm) / of(550.0);
    for nm in [380.0, 400.0, 450.0, 500.0, 600.0, 700.0, 780.0] {
        let (ours, theirs) = (relative(&published::air_cross_section, nm), relative(&published, nm));
        assert!((ours / theirs - 1.0).abs() < 2e-4, "{ours} instead of {theirs} at {nm} nm");
        assert!((ours / (550.0 / nm).powi(4) - 1.0).abs() > 2e-3, "no dispersion at {nm} nm");
    }
    // Bates 1984 gives a King factor of 1.048 there, and a depolarisation of 0.028.
    assert!((published::air_king_factor(550.0) - 1.048).abs() < 1e-3);
    assert!((published::depolarisation(1.048) - 0.0279).abs() < 1e-4);
}

#[test]
fn coefficients_are_those_of_published_numbers() {
    let sky = Atmosphere {
        ground_radius_km: 6360.0,
        top_radius_km: 6460.0,
        ground_albedo: Spectrum::Grey(0.3),
        air_scattering_at_1_um: 1.24062e-3,
        air_scale_height_km: 8.0,
        air_law: AirLaw::FourthPower,
        aerosol_optical_depth_at_1_um: 0.150,
        aerosol_angstrom_exponent: 1.3,
        aerosol_spectrum: None,
        aerosol_scale_height_km: 1.2,
        aerosol_albedo: MARS_DUST_ALBEDO,
        aerosol_asymmetry: 0.8,
        ozone_column_du: 300.0,
        ozone_bottom_km: 10.0,
        ozone_peak_km: 25.0,
        ozone_top_km: 40.0,
        ozone_cross_section_m2: OZONE_CROSS_SECTION_233K,
    };
    // Bruneton and Neyret 2008, Sec. 2.1, in three digits, DOI 10.1111/j.1467-8659.2008.01245.x.
    for (nm, per_km) in [(680.0, 5.8e-3), (550.0, 13.5e-3), (440.0, 33.1e-3)] {
        assert_close(sky.coefficients(nm).air_scattering, per_km, 0.005);
    }
    // OPAC's continental polluted aerosol, 0.327 at 550 nm (Hess, Koepke and Schult 1998), to the digits of 0.150 at 1
    // µm.
    let haze = sky.coefficients(550.0);
    assert_close(haze.aerosol_extinction * 1.2, 0.327, 0.003);
    assert_close(haze.aerosol_scattering / haze.aerosol_extinction, 0.73 + (0.967 - 0.73) * 162.0 / 262.0, 1e-12);
    // The column of the tent is half its base, whatever its peak: N σ, with N = 300 DU.
    let depth = column_to_top(&sky.medium(), 0.0, 1.0)[2] * sky.coefficients(605.0).ozone_absorption;
    assert_close(depth, 300.0 * 2.687e20 * 5.176e-25, 1e-12);
    assert_eq!(sky.coefficients(555.0).ground_albedo, 0.3);
    let line = Atmosphere { ozone_column_du: 0.0, ozone_bottom_km: 25.0, ozone_top_km: 25.0, ..sky };
    assert_eq!(line.coefficients(605.0).ozone_absorption, 0.0);
}

#[test]
fn a_dobson_unit_is_ten_micrometres_of_ideal_gas() {
    // p / (k T): 101325 Pa, CODATA 2018, 273.15 K.
    let loschmidt = 101_325.0 / (1.380_649e-23 * 273.15);
    assert_close(DOBSON_UNIT, 10e-6 * loschmidt, 1e-4);
}

#[test]
fn a_spectrum_is_straight_between_its_rows_and_level_beyond() {
    let spectrum = Spectrum::from_csv("# of nothing\nwavelength_nm,value\n400, 1\n500,3\n700,2\n");
    for (nm, value) in
        [(300.0, 1.0), (400.0, 1.0), (450.0, 2.0), (500.0, 3.0), (600.0, 2.5), (700.0, 2.0), (900.0, 2.0)]
    {
        assert_eq!(spectrum.at(nm), value, "{nm} nm");
    }
    assert_eq!(Spectrum::Grey(0.25).at(123.0), 0.25);
}

#[test]
fn gauss_legendre_is_exact_for_polynomials() {
    let rule = GaussLegendre::<10>::new();
    assert_close(rule.integrate(1.0, 3.0, |x| x.powi(19)), (3f64.powi(20) - 1.0) / 20.0, 1e-14);
    for (node, row) in rule.nodes.iter().zip(&rule.running) {
        let ninth: f64 = row.iter().zip(&rule.nodes).map(|(w, x)| w * x.powi(9)).sum();
        assert!((ninth - node.powi(10) / 10.0).abs() < 1e-15);
    }
}

#[test]
fn vertical_column_of_an_exponential_atmosphere_is_h_times_one_minus_exp() {
    for altitude in [0.0, 1.0, 20.0, 99.0] {
        let column = column_to_top(&EARTH, altitude, 1.0);
        for (i, scale_height) in [(0, 8.0_f64), (1, 1.2)] {
            let depth = (100.0 - altitude) / scale_height;
            let expected = scale_height * (-altitude / scale_height).exp() * -(-depth).exp_m1();
            assert_close(column[i], expected, 1e-12);
        }
    }
}

#[test]
fn vertical_ozone_column_is_half_of_its_thickness() {
    assert_close(column_to_top(&EARTH, 0.0, 1.0)[2], 15.0, 1e-13);
    assert_close(column_to_top(&EARTH, 25.0, 1.0)[2], 7.5, 1e-13);
    assert_eq!(column_to_top(&EARTH, 40.0, 1.0)[2], 0.0);
}

#[test]
fn columns_agree_with_simpson() {
    let thin_haze = Medium { aerosol_scale_height_km: 0.3, ..EARTH };
    for (medium, tolerance) in [(EARTH, 1e-10), (thin_haze, 1e-9)] {
        for altitude in [0.0, 0.01, 1.0, 10.0, 24.0, 39.0, 70.0, 99.0] {
            let radius = medium.ground_radius_km + altitude;
            let horizon = -(1.0 - (medium.ground_radius_km / radius).powi(2)).sqrt();
            for mu in [horizon, 0.5 * horizon, 1e-3 * horizon, 0.0, 1e-3, 0.02, 0.1, 0.4, 0.9] {
                let column = column_to_top(&medium, altitude, mu);
                let expected = column_by_simpson(&medium, altitude, mu);
                for i in 0..3 {
                    assert_close(column[i], expected[i], tolerance);
                }
            }
        }
    }
}

#[test]
fn a_chord_seen_from_space_is_twice_its_half() {
    let grazing = Line::new(&EARTH, 200.0, -half_chord(6560.0, 6365.0) / 6560.0);
    let chord = column_to_top(&EARTH, 200.0, grazing.mu);
    let half = column_to_top(&EARTH, 5.0, 0.0);
    for i in 0..3 {
        assert_close(chord[i], 2.0 * half[i], 1e-11);
    }
    assert_eq!(column_to_top(&EARTH, 200.0, -0.1), [0.0; CONSTITUENTS]);
}

#[test]
fn radiance_towards_a_zenith_sun_is_depth_times_its_transmittance() {
    // Every path, down to a point and on to the observer, is the same column: ∫ β ρ exp(−τ) = τ
    // exp(−τ).
    let depth = 0.05 * 8.0 * -(-100.0_f64 / 8.0).exp_m1();
    let up = [0.0, 0.0, 1.0];
    let radiance = scattered_radiance(&EARTH, &ONLY_AIR, &ray(0.0, up, up));
    assert_close(radiance, air_phase(0.0, 1.0) * depth * (-depth).exp(), 1e-11);
}

#[test]
fn radiance_straight_down_from_space_is_half_of_what_the_double_path_removes() {
    let depth = 0.05 * 8.0 * -(-100.0_f64 / 8.0).exp_m1();
    let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
    let expected = air_phase(0.0, -1.0) * 0.5 * -(-2.0 * depth).exp_m1();
    for altitude in [100.0, 101.0, 400.0, 384400.0] {
        let radiance = scattered_radiance(&EARTH, &ONLY_AIR, &ray(altitude, down, up));
        assert_close(radiance, expected, 1e-10);
    }
}

#[test]
fn thin_zenith_at_sun_minus_four_is_lit_from_the_shadow_edge_up() {
    let edge: f64 = 6360.0 * (1.0 / 4.0_f64.to_radians().cos() - 1.0);
    let sun = direction(-4.0, 0.0);
    let lit_column = |h: f64| h * ((-edge / h).exp() - (-100.0 / h).exp());
    let air = Coefficients { air_scattering: 1e-9, ..ONLY_AIR };
    let haze = Coefficients {
        air_scattering: 0.0,
        air_depolarisation: 0.0,
        aerosol_extinction: 1e-9,
        aerosol_scattering: 1e-9,
        ozone_absorption: 0.0,
        gas_absorption: [0.0; 2],
        ground_albedo: 0.0,
        aerosol_phase: None,
    };
    let zenith = ray(0.0, [0.0, 0.0, 1.0], sun);
    let [air, haze] = [air, haze].map(|band| scattered_radiance(&EARTH, &band, &zenith));
    // The longest path is 600 km at density 1: at 1e-9 km⁻¹ it takes less than 1e-6 away.
    assert_close(air / (1e-9 * air_phase(0.0, sun[2])), lit_column(8.0), 1e-6);
    assert_close(haze / (1e-9 * aerosol_phase(0.8, sun[2])), lit_column(1.2), 1e-6);
}

#[test]
fn thin_lit_slant_is_its_column() {
    let thin = Coefficients { air_scattering: 1e-9, ..ONLY_AIR };
    let sun = direction(50.0, 0.0);
    for elevation in [0.0, 0.5, 10.0, 60.0] {
        let view = direction(elevation, 130.0);
        let radiance = scattered_radiance(&EARTH, &thin, &ray(0.0, view, sun));
        let column = column_to_top(&EARTH, 0.0, view[2])[0];
        assert_close(radiance / (1e-9 * air_phase(0.0, dot(view, sun))), column, 1e-6);
    }
}

#[test]
fn radiance_is_linear_in_the_scattering_alone() {
    let albedo = |scattering| Coefficients {
        air_scattering: 0.0,
        air_depolarisation: 0.0,
        aerosol_extinction: 0.04,
        aerosol_scattering: scattering,
        ozone_absorption: 1e-3,
        gas_absorption: [0.0; 2],
        ground_albedo: 0.0,
        aerosol_phase: None,
    };
    let ray = ray(0.0, direction(3.0, 20.0), direction(5.0, 0.0));
    let radiance = scattered_radiance_bands(&EARTH, &[albedo(0.04), albedo(0.01)], &ray);
    assert_close(radiance[0], 4.0 * radiance[1], 1e-12);
}

#[test]
fn an_opaque_atmosphere_still_has_a_radiance() {
    let opaque = Coefficients { air_scattering: 50.0, ..BANDS[0] };
    for ray in rays().iter().step_by(11) {
        let radiance = scattered_radiance(&EARTH, &opaque, ray);
        assert!((0.0..1.0).contains(&radiance), "{radiance} along {ray:?}");
    }
}

#[test]
fn night_is_black() {
    for elevation in [0.0, 30.0, 90.0] {
        let ray = ray(0.0, direction(elevation, 40.0), direction(-90.0, 0.0));
        assert_eq!(scattered_radiance(&EARTH, &BANDS[0], &ray), 0.0);
    }
}

#[test]
fn empty_space_and_the_ground_underfoot_are_black() {
    let sun = direction(30.0, 0.0);
    for (altitude, elevation) in [(100.1, 1.0), (400.0, -5.0), (0.0, -0.01), (0.0, -90.0)] {
        let ray = ray(altitude, direction(elevation, 0.0), sun);
        assert_eq!(scattered_radiance(&EARTH, &BANDS[0], &ray), 0.0);
    }
}

#[test]
fn shadow_edges_are_the_distances_where_the_sun_appears() {
    let mut edges = 0;
    for ray in rays() {
        let Some(path) = ViewPath::new(&EARTH, &ray) else {
            continue;
        };
        for s in path.sun_perigee_crossings(0.0).into_iter().flatten() {
            let behind = path.sunward + s * path.nu < -1.0;
            let (before, after) = (s - 1e-3, s + 1e-3);
            if behind && before > 0.0 && after < path.length {
                assert_ne!(path.is_lit(&EARTH, before), path.is_lit(&EARTH, after));
                edges += 1;
            }
        }
    }
    assert!(edges > 50, "only {edges} edges were looked at");
}

#[test]
fn radiance_agrees_with_brute_force() {
    // Midpoint steps of 0.1 km towards the sun and 0.03 to 0.4 km along the view, in haze of
    // 1.2 km, agree to 3e-5.
    let cases = [
        (0.0, 90.0, 0.0, 45.0),
        (0.0, 5.0, 30.0, 20.0),
        (0.0, 0.5, 170.0, 2.0),
        (0.0, 20.0, 10.0, -4.0),
        (2.0, -1.0, 60.0, 10.0),
        (60.0, -5.0, 150.0, -1.0),
    ];
    for (altitude, elevation, azimuth, sun) in cases {
        let ray = ray(altitude, direction(elevation, azimuth), direction(sun, 0.0));
        let length = ViewPath::new(&EARTH, &ray).unwrap().length;
        for band in [&BANDS[0], &BANDS[2]] {
            let expected = radiance_by_brute_force(&EARTH, band, &ray, length);
            assert_close(scattered_radiance(&EARTH, band, &ray), expected, 1e-4);
        }
    }
}

#[test]
fn a_thousand_times_finer_changes_less_than_1e_8() {
    let mut compared = 0;
    for ray in rays() {
        let radiance = scattered_radiance_bands(&EARTH, &BANDS, &ray);
        let fine = scattered_radiance_bands_within(1e-11, &EARTH, &BANDS, &ray);
        for (radiance, fine) in radiance.iter().zip(&fine).filter(|(_, fine)| **fine > 1e-30) {
            assert_close(*radiance, *fine, 1e-8);
            compared += 1;
        }
    }
    assert!(compared > 500, "only {compared} radiances were compared");
}

#[test]
fn bands_together_equal_bands_alone() {
    for ray in rays().iter().step_by(7) {
        let together = scattered_radiance_bands(&EARTH, &BANDS, ray);
        for (band, radiance) in BANDS.iter().zip(together) {
            assert!((scattered_radiance(&EARTH, band, ray) - radiance).abs() <= 2e-8 * radiance);
        }
    }
}

#[test]
fn radiance_is_continuous_as_the_observer_goes_up() {
    // 1 m of air at these coefficients is at most 5e-5 of optical depth, against radiances of
    // some 1e-2 sr⁻¹.
    let sun = direction(3.0, 0.0);
    for elevation in [90.0, 20.0, 0.0, -30.0] {
        let view = direction(elevation, 25.0);
        for altitude in [0.0, 0.5, 1.2, 10.0, 25.0, 40.0, 99.9995, 150.0] {
            let [low, high] = [altitude, altitude + 1e-3]
                .map(|altitude| scattered_radiance(&EARTH, &BANDS[0], &ray(altitude, view, sun)));
            assert!((low - high).abs() <= 1e-2 * low.max(high) + 1e-4, "{altitude} {elevation}");
        }
    }
}

#[test]
fn entering_from_space_equals_standing_at_the_entry() {
    // Down the plane of the sun, from 500 km to the top: the view turns with the vertical.
    let (view, sun) = (direction(-35.0, 0.0), direction(40.0, 0.0));
    let observer = Line::new(&EARTH, 500.0, view[2]);
    let entry = entry_distance(&EARTH, &observer, view[0]).unwrap();
    let turn = (entry * view[0]).atan2(6860.0 + entry * view[2]).to_degrees();
    let there = ray(100.0, direction(-35.0 + turn, 0.0), direction(40.0 + turn, 0.0));
    let from_space = scattered_radiance(&EARTH, &BANDS[1], &ray(500.0, view, sun));
    assert_close(from_space, scattered_radiance(&EARTH, &BANDS[1], &there), 1e-9);
}

#[test]
fn a_way_to_the_top_has_the_optical_depth_of_its_column() {
    let thin_haze = Medium { aerosol_scale_height_km: 0.05, ..EARTH };
    let mut compared = 0;
    for (medium, band) in [(EARTH, BANDS[0]), (EARTH, BANDS[1]), (thin_haze, BANDS[0]), (thin_haze, BANDS[2])] {
        let shells = Shells::new(&medium, &band, [0.0, 0.0, 1.0]);
        for altitude in [0.0, 0.01, 3.0, 24.0, 39.0, 70.0, 99.0] {
            for elevation in [-5.0, -0.5, 0.0, 0.1, 3.0, 40.0, 90.0] {
                let direction = direction(elevation, 30.0);
                let way = Way::new(&shells, [0.0, 0.0, medium.ground_radius_km + altitude], direction);
                if way.ground().is_some() {
                    continue;
                }
                let column = column_to_top(&medium, altitude, direction[2]);
                let expected = band.optical_depth(column);
                assert!((way.depth() - expected).abs() <= 1e-5 * expected + 1e-6, "{} {expected}", way.depth());
                let behind = way.place_behind(0.3 * way.depth());
                let height = dot(behind, behind).sqrt() - medium.ground_radius_km;
                let up = dot(behind, direction) / dot(behind, behind).sqrt();
                let rest = band.optical_depth(column_to_top(&medium, height.max(0.0), up));
                assert!((rest - 0.7 * expected).abs() <= 1e-5 * expected + 1e-6, "{rest} {expected}");
                compared += 1;
            }
        }
    }
    assert!(compared > 80, "{compared}");
}
