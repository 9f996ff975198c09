//! Scene files as people keep them: new, check, show; presets; tables of their own; place and time; completions and
//! manual.

use std::path::Path;

use serde_json::Value;
use sorairo::low_level::plan::direction;
use sorairo::scene::{Fit, Preset, Scene, reference};
use sorairo::{PixelFormat, Plan};
use sorairo_evaluation::error::{true_xyz, xyz};
use sorairo_tests::program::{Ended, contents, read_png, run, succeed};
use strum::IntoEnumIterator;
use tempfile::{TempDir, tempdir};

fn folder() -> TempDir {
    tempdir().expect("a folder for temporary files")
}

fn name(preset: Preset) -> &'static str {
    preset.into()
}

/// The lines of a refusal: exit code 2, nothing on standard output, every line from the program itself.
fn refusal(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let before = contents(folder);
    let Ended { code, stdout, stderr } = run(folder, arguments);
    assert_eq!((code, stdout.as_str()), (Some(2), ""), "{arguments:?}: {stderr}");
    assert!(contents(folder) == before, "{arguments:?} changed the folder");
    let lines = stderr.lines().map(|line| line.strip_prefix("sorairo: ").map(str::to_owned));
    lines.collect::<Option<_>>().unwrap_or_else(|| panic!("{arguments:?}: {stderr}"))
}

#[test]
fn the_reference_page_is_what_the_keys_say() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/scene-reference.md");
    let kept = std::fs::read_to_string(page).expect("docs/scene-reference.md");
    assert!(
        kept == reference::markdown(sorairo_cli::flags::flag),
        "docs/scene-reference.md is out of date: run `cargo run --release -- scene reference > docs/scene-reference.md`"
    );
    assert_eq!(succeed(folder().path(), &["scene", "reference"]).stdout, kept);
}

#[test]
fn a_new_scene_is_its_preset_and_never_replaces_a_file() {
    let folder = folder();
    for preset in Preset::iter() {
        let file = format!("{}.toml", name(preset));
        succeed(folder.path(), &["scene", "new", &file, "--preset", name(preset)]);
        assert_eq!(succeed(folder.path(), &["scene", "check", &file]).stdout, format!("{file}: ok\n"));
        assert_eq!(Scene::read(&folder.path().join(&file), None).unwrap(), Scene::preset(preset));
        assert!(refusal(folder.path(), &["scene", "new", &file])[0].contains("exists"));
    }
    succeed(folder.path(), &["scene", "new"]);
    assert_eq!(Scene::read(&folder.path().join("scene.toml"), None).unwrap(), Scene::default());
    assert!(refusal(folder.path(), &["scene", "new", "nowhere/a.toml"])[0].contains("folder does not exist"));
}

#[test]
fn check_names_everything_that_is_wrong_with_line_and_column() {
    let folder = folder();
    let check = |text: &str| {
        std::fs::write(folder.path().join("a.toml"), text).unwrap();
        refusal(folder.path(), &["scene", "check", "a.toml"])
    };
    assert_eq!(
        check("[sun]\nelevatoin = 4\nazimuth = 'x'\n[camera]\n  colour = 1\n"),
        [
            "a.toml, line 2, column 1 (elevatoin = 4): unknown key `elevatoin`; did you mean `elevation`?",
            "a.toml, line 3, column 11 (azimuth = 'x'): invalid type: string \"x\", expected a number",
            "a.toml, line 5, column 3 (colour = 1): unknown key `colour`; did you mean `render.color`?",
        ]
    );
    assert_eq!(
        check("[sun]\nelevation = 100\n\n[atmosphere.ozone]\npeak = 9\n"),
        [
            "a.toml, line 2, column 13 (elevation = 100): sun.elevation is 100; it must lie between -90 and 90 degrees",
            "a.toml, line 5, column 8 (peak = 9): atmosphere.ozone.peak is 9; it must lie between 10.1 and 100 km",
        ]
    );
    assert_eq!(
        check("preset = 'mars'\natmosphere.ozone = { column = 300, top = 200 }\n"),
        ["a.toml, line 2, column 42 (atmosphere.ozone = { column = 300, top = 200 }): atmosphere.ozone.top is 200; \
          it must lie between 25.1 and 110 km"]
    );
    assert!(check("sun.place = '43,141'")[0].contains("needs a time"));
    assert!(refusal(folder.path(), &["scene", "check", "b.toml"])[0].contains("scene file b.toml cannot be read"));
    std::fs::write(folder.path().join("b.toml"), b"[sun]\n# \xff\n").unwrap();
    assert_eq!(
        refusal(folder.path(), &["scene", "check", "b.toml"]),
        ["the scene file b.toml is not UTF-8 text, from line 2 on"]
    );
    std::fs::write(folder.path().join("b.toml"), vec![b'#'; (256 << 10) + 1]).unwrap();
    assert!(refusal(folder.path(), &["scene", "check", "b.toml"])[0].contains("larger than 256 KiB"));
}

#[test]
fn a_value_out_of_range_is_named_where_it_stands_unless_a_flag_gave_it() {
    let folder = folder();
    std::fs::write(folder.path().join("a.toml"), "[observer]\naltitude = -3\n").unwrap();
    let render = |flags: &[&str]| refusal(folder.path(), &[&["render", "--scene", "a.toml"], flags].concat());
    assert!(render(&[])[0].starts_with("a.toml, line 2, column 12 (altitude = -3): observer.altitude is -3"));
    assert!(render(&["--altitude", "-4"])[0].starts_with("--altitude (observer.altitude) is -4"));
}

#[test]
fn show_prints_the_scene_that_it_reads() {
    let folder = folder();
    std::fs::write(folder.path().join("sun.csv"), "380,1\n780,2\n").unwrap();
    let given = "preset = 'hazy'\n[sun]\nspectrum = 'sun.csv'\nplace = '43.06,141.35'\n[camera]\nfov = 100\n[render]\nexposure = -3\n";
    std::fs::write(folder.path().join("a.toml"), given).unwrap();
    let flags = ["--time", "2026-06-21T04:30:00+09:00", "--size", "64x32", "--bands", "430,500,600,700"];
    let shown = succeed(folder.path(), &[&["scene", "show", "a.toml"], &flags[..]].concat()).stdout;
    std::fs::create_dir(folder.path().join("elsewhere")).unwrap();
    std::fs::write(folder.path().join("elsewhere/b.toml"), &shown).unwrap();
    assert_eq!(succeed(folder.path(), &["scene", "show", "elsewhere/b.toml"]).stdout, shown);
    let scene = Scene::read(&folder.path().join("elsewhere/b.toml"), None).unwrap();
    assert_eq!((scene.began_as(), scene.camera.fov, scene.camera.size.width), (Preset::Hazy, Some(100.0), 64));
    assert_eq!(scene.render.bands, Some(vec![430.0, 500.0, 600.0, 700.0]));
    assert!((4.0..5.0).contains(&scene.sun.elevation) && (61.0..63.0).contains(&scene.sun.azimuth), "{:?}", scene.sun);
    for preset in Preset::iter() {
        let shown = succeed(folder.path(), &["scene", "show", "--preset", name(preset)]).stdout;
        assert_eq!(Scene::parse(&shown, "shown", None).unwrap(), Scene::preset(preset));
    }
}

#[test]
fn the_regression_fit_holds_for_every_preset() {
    for preset in Preset::iter() {
        for sun in [2.0, 30.0] {
            let mut scene = Scene::preset(preset);
            scene.sun.elevation = sun;
            scene.render.fit = Fit::Regression;
            scene.camera.size = "4x2".parse().unwrap();
            let plan = Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb);
            let views: Vec<_> = (0..=9)
                .flat_map(|i| (0..4).map(move |j| direction(10.0 * f64::from(i), 45.0 * f64::from(j)).as_vec3()))
                .collect();
            let worst = true_xyz(&scene, &views)
                .unwrap()
                .into_iter()
                .zip(&views)
                .map(|(truth, &view)| (xyz(&plan, view) - truth).abs().max_element() / truth.max_element())
                .inspect(|error| assert!(error.is_finite(), "{preset:?}, sun at {sun}"))
                .fold(0.0, f64::max);
            // A hundredth of the brightest component is half of what an eye sees; the fit has 0.2 % of luminance by day
            // and by low sun on the earth preset.
            assert!(worst < 0.01, "{preset:?}, sun at {sun}: {worst}");
        }
    }
}

#[test]
fn every_preset_has_its_own_sky() {
    let folder = folder();
    let colour = |preset: &str| {
        let flags = ["--projection", "fisheye", "--size", "33x33", "--device", "cpu", "-o", "a.png"];
        succeed(folder.path(), &[&["render", "--preset", preset], &flags[..]].concat());
        // Away from the sun, half-way down to the horizon.
        read_png(&folder.path().join("a.png")).at(16, 24).map(f64::from)
    };
    let blueness = |[red, _, blue]: [f64; 3]| blue / red;
    let [earth, hazy, mountain, mars] = ["earth", "hazy", "mountain", "mars"].map(|preset| blueness(colour(preset)));
    assert!(mountain > earth && earth > hazy && hazy > 1.0, "{mountain} {earth} {hazy}");
    assert!(mars < 0.95, "Mars is butterscotch: {mars}");
}

/// The radiance in one direction by wavelength, as `sorairo spectrum` prints its dense column.
fn spectrum(folder: &Path, scene: &str, wavelengths: &str) -> Vec<f64> {
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    let view = ["--view-elevation", "40", "--view-azimuth", "70", "--wavelengths", wavelengths];
    let csv = succeed(folder, &[&["spectrum", "--scene", "scene.toml"], &view[..]].concat()).stdout;
    csv.lines().skip(1).map(|row| row.rsplit(',').next().unwrap().parse().unwrap()).collect()
}

#[test]
fn tables_of_a_persons_own_take_the_place_of_the_programs() {
    let folder = folder();
    let path = folder.path();
    let of = |scene: &str| spectrum(path, &format!("preset = 'earth'\n{scene}"), "400,500,600");
    let close = |a: &[f64], b: &[f64]| {
        assert_eq!(a.len(), b.len());
        // f32 sums, in another order of bands.
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * b.abs()), "{a:?} {b:?}");
    };
    std::fs::write(path.join("sun.csv"), "\u{feff}wavelength_nm,irradiance\r\n380,2\r\n780,2\r\n").unwrap();
    let flat = of("sun.spectrum = 'flat'");
    close(&of("sun.spectrum = 'sun.csv'"), &flat.iter().map(|value| 2.0 * value).collect::<Vec<_>>());
    close(&of("sun = { spectrum = 'flat', distance = 2 }"), &flat.iter().map(|value| value / 4.0).collect::<Vec<_>>());
    std::fs::write(path.join("none.csv"), "380,0\n780,0\n").unwrap();
    close(&of("atmosphere.ozone.cross_section = 'none.csv'"), &of("atmosphere.ozone.column = 0"));
    std::fs::write(path.join("half.csv"), "380,0.5\n780,0.5\n").unwrap();
    let table = "[atmosphere.aerosol]\noptical_depth = 0.3\nsingle_scattering_albedo_spectrum = 'half.csv'";
    close(&of(table), &of("[atmosphere.aerosol]\noptical_depth = 0.3\nsingle_scattering_albedo = 0.5"));
}

#[test]
fn a_table_is_found_beside_its_scene_file() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("scenes")).unwrap();
    std::fs::write(folder.path().join("scenes/sun.csv"), "380,2\n780,2\n").unwrap();
    std::fs::write(folder.path().join("scenes/a.toml"), "sun.spectrum = 'sun.csv'").unwrap();
    succeed(folder.path(), &["render", "--scene", "scenes/a.toml", "--size", "4x2", "--device", "cpu", "-o", "a.png"]);
}

#[test]
fn a_wrong_table_is_refused_by_its_line() {
    let folder = folder();
    let path = folder.path();
    let cases = [
        ("380,1\n380,1\n780,1\n", "line 2: 380 nm stands twice, here and in line 1"),
        ("380,1\n780,1\n500,1\n", "line 3: 500 nm follows 780 nm"),
        ("380,1\n500,nan\n780,1\n", "line 2: column 2 is \"nan\", not a finite number"),
        ("380,1\n500,\n780,1\n", "line 2: column 2 is empty"),
        ("380,1\n500\n780,1\n", "line 2: 1 column instead of 2"),
        ("380,1\n500,-1\n780,1\n", "line 2: column 2 is -1; it must be 0 or more"),
        ("400,1\n700,1\n", "380 to 400 nm and 700 to 780 nm are missing"),
        ("", "at least two rows"),
    ];
    for (csv, words) in cases {
        std::fs::write(path.join("a.csv"), csv).unwrap();
        for key in
            ["sun.spectrum", "atmosphere.ozone.cross_section", "atmosphere.aerosol.single_scattering_albedo_spectrum"]
        {
            std::fs::write(path.join("a.toml"), format!("\n{key} = 'a.csv'\n")).unwrap();
            let said = refusal(path, &["render", "--scene", "a.toml"]);
            assert!(
                said.len() == 1 && said[0].starts_with("a.toml, line 2, column ") && said[0].contains(words),
                "{said:?}"
            );
            assert!(said[0].contains("a.csv"), "{said:?}");
        }
    }
    std::fs::write(path.join("a.csv"), "380,0.9\n500,1.2\n780,1\n").unwrap();
    for key in ["atmosphere.aerosol.single_scattering_albedo_spectrum", "ground.albedo"] {
        std::fs::write(path.join("a.toml"), format!("{key} = 'a.csv'\n")).unwrap();
        let said = refusal(path, &["scene", "check", "a.toml"]);
        assert!(said[0].contains("a.csv, line 2 of which holds 1.2 at 500 nm; an albedo is at most 1"), "{said:?}");
    }
    // A hole of a gigabyte: refused by its length, not read.
    let huge = std::fs::File::create(path.join("huge.csv")).unwrap();
    huge.set_len(1 << 30).unwrap();
    drop(huge);
    std::fs::write(path.join("a.toml"), "sun.spectrum = 'huge.csv'\n").unwrap();
    let ended = run(path, &["scene", "check", "a.toml"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("larger than 4096 KiB"), "{}", ended.stderr);
    std::fs::remove_file(path.join("huge.csv")).unwrap();
    std::fs::write(path.join("a.csv"), "400,1\n700,1\n").unwrap();
    std::fs::write(path.join("a.toml"), "sun.spectrum = 'none.csv'\n").unwrap();
    assert!(refusal(path, &["scene", "check", "a.toml"])[0].contains("none.csv cannot be read: No such file"));
}

#[test]
fn a_table_in_another_unit_is_refused_with_the_unit_that_it_may_be_in() {
    let folder = folder();
    let path = folder.path();
    let cases = [
        ("sun.spectrum", "1e38", "a solar irradiance is at most 100 W·m⁻²·nm⁻¹"),
        ("sun.spectrum", "1e300", "a solar irradiance is at most 100 W·m⁻²·nm⁻¹"),
        ("sun.spectrum", "2100", "the table may be in mW·m⁻²·nm⁻¹ or W·m⁻²·µm⁻¹"),
        ("sun.spectrum", "2100000000", "the table may be in W·m⁻³"),
        ("sun.spectrum", "0", "a solar irradiance reaches at least 0.000000001 W·m⁻²·nm⁻¹"),
        ("atmosphere.ozone.cross_section", "1.2e-21", "at most 1e-22 m²; the table may be in cm²"),
        ("atmosphere.ozone.cross_section", "0.005", "the table may be in Mb"),
        (
            "atmosphere.aerosol.single_scattering_albedo_spectrum",
            "90",
            "an albedo is at most 1; the table may be in per cent",
        ),
        ("ground.albedo", "30", "an albedo is at most 1; the table may be in per cent"),
    ];
    std::fs::create_dir(path.join("scenes")).unwrap();
    for (key, value, words) in cases {
        let rest = if value == "0" { "0" } else { "1e-30" };
        std::fs::write(path.join("scenes/a.csv"), format!("380,{rest}\n500,{value}\n780,{rest}\n")).unwrap();
        std::fs::write(path.join("scenes/a.toml"), format!("{key} = 'a.csv'\n")).unwrap();
        for command in
            [&["scene", "check", "scenes/a.toml"][..], &["render", "--device", "cpu", "--scene", "scenes/a.toml"]]
        {
            let said = refusal(path, command);
            // Of equal values the last is named.
            let row = if value == "0" {
                "line 3 of which holds 0 at 780 nm".into()
            } else {
                format!("line 2 of which holds {value} at 500 nm")
            };
            assert!(said.len() == 1 && said[0].contains(&row) && said[0].contains(words), "{key}, {value}: {said:?}");
        }
    }
    // What nature has passes: the sun of Mercury, and ozone in m² with its strong band in the ultraviolet.
    for (key, table) in [
        ("sun.spectrum", "380,7\n500,14\n780,8\n"),
        ("atmosphere.ozone.cross_section", "250,1.1e-21\n350,1e-26\n380,1e-27\n600,5e-25\n780,2e-26\n"),
    ] {
        std::fs::write(path.join("scenes/a.csv"), table).unwrap();
        std::fs::write(path.join("scenes/a.toml"), format!("{key} = 'a.csv'\n")).unwrap();
        succeed(path, &["scene", "check", "scenes/a.toml"]);
    }
}

#[test]
fn wavelengths_end_where_a_table_ends() {
    let folder = folder();
    std::fs::write(folder.path().join("sun.csv"), "375,1\n790,1\n").unwrap();
    let scene = "sun.spectrum = 'sun.csv'";
    assert_eq!(spectrum(folder.path(), scene, "375,790").len(), 2);
    let view = ["spectrum", "--scene", "scene.toml", "--view-elevation", "40", "--view-azimuth", "70"];
    let beyond = refusal(folder.path(), &[&view[..], &["--wavelengths", "800"]].concat());
    assert!(beyond[0].contains("--wavelengths holds 800; wavelengths must lie between 375 and 790 nm"), "{beyond:?}");
    let beyond = refusal(folder.path(), &[&view[..], &["--bands", "370,500,600,700"]].concat());
    assert!(beyond[0].contains("--bands (render.bands) is 370; it must lie between 375 and 790 nm"), "{beyond:?}");
}

#[test]
fn place_and_time_put_the_sun_in_the_summary_and_the_json() {
    let folder = folder();
    let render = |flags: &[&str]| {
        let always = ["render", "--size", "4x2", "--device", "cpu", "-o", "a.png", "--json"];
        let ended = succeed(folder.path(), &[&always, flags].concat());
        let report: Value = serde_json::from_str(&ended.stdout).unwrap();
        let sun = ["sun_elevation", "sun_azimuth"].map(|key| report[key].as_f64().unwrap());
        let said = format!("sun {:.2}° high at azimuth {:.2}°", sun[0], sun[1]);
        assert!(ended.stderr.contains(&said), "no {said:?} in {}", ended.stderr);
        sun
    };
    // Reda and Andreas, NREL/TP-560-34302, Appendix A.5, without refraction; 0.01° is promised.
    let golden = ["--place", "39.742476,-105.1786", "--time", "2003-10-17T12:30:30-07:00", "--altitude", "1.83014"];
    let [elevation, azimuth] = render(&golden);
    assert!((elevation - 39.872046).abs() < 0.01 && (azimuth - 194.340241).abs() < 0.01, "{elevation} {azimuth}");
    assert_eq!(render(&["--sun-elevation", "12", "--sun-azimuth", "-30"]), [12.0, -30.0]);
    // A flag takes the place of its key and leaves the other.
    let file = "[sun]\nplace = \"39.742476,-105.1786\"\ntime = 2003-10-17T19:30:30Z\n[observer]\naltitude = 1.83014\n";
    std::fs::write(folder.path().join("a.toml"), file).unwrap();
    assert_eq!(render(&["--scene", "a.toml"]), [elevation, azimuth]);
    let later = render(&["--scene", "a.toml", "--time", "2003-10-17T20:30:30Z"]);
    assert!(later[1] > azimuth + 10.0, "{later:?}");
    for flag in ["--sun-elevation", "--sun-azimuth"] {
        let said = refusal(folder.path(), &["render", "--scene", "a.toml", flag, "5"]);
        assert!(
            said.len() == 1 && said[0].contains(flag) && said[0].contains("cannot be given beside --place"),
            "{said:?}"
        );
    }
    let said = refusal(folder.path(), &["sequence", "--scene", "a.toml", "--sun-elevation", "0:5:1"]);
    assert!(said.len() == 1 && said[0].contains("cannot be given beside --place"), "{said:?}");
    // South of the equator, where a latitude looks like a flag.
    render(&["--place", "-33.9,151.2", "--time", "2026-06-21T04:30:00Z"]);
}

#[test]
fn a_wrong_place_or_time_exits_with_2_and_says_what_is_allowed() {
    let folder = folder();
    let time = ["--time", "2026-06-21T04:30:00Z"];
    let cases: [(&[&str], &[&str]); 9] = [
        (&["--place", "43,141"], &["--place (sun.place) needs a time", "--time"]),
        (&time, &["--time (sun.time) needs a place", "--place"]),
        (&["--place", "43,141", "--sun-elevation", "3"], &["--place", "cannot be used with", "--sun-elevation"]),
        (&["--place", "43,141", "--sun-azimuth", "3"], &["--place", "cannot be used with", "--sun-azimuth"]),
        (
            &["--time", "2026-06-21T04:30:00Z", "--sun-azimuth", "3"],
            &["--time", "cannot be used with", "--sun-azimuth"],
        ),
        (&["--place", "43"], &["--place", "LATITUDE,LONGITUDE"]),
        (&["--place", "91,0"], &["--place", "-90 to 90 north"]),
        (&["--place", "43,141", "--time", "2026-06-21"], &["--time", "an offset from UTC"]),
        (&["--place", "43,141", "--time", "9999-06-21T00:00:00Z"], &["cannot be placed at 9999"]),
    ];
    for (flags, named) in cases {
        let ended = run(folder.path(), &[&["render", "--device", "cpu"], flags].concat());
        assert_eq!(ended.code, Some(2), "{flags:?}: {}", ended.stderr);
        assert!(named.iter().all(|part| ended.stderr.contains(part)), "{flags:?}: {}", ended.stderr);
    }
    assert!(contents(folder.path()).is_empty());
}

#[test]
fn a_scene_file_is_named_in_either_way_and_help_keeps_place_and_time_together() {
    let folder = folder();
    std::fs::write(folder.path().join("a.toml"), "sun.elevation = 7.5\n").unwrap();
    for command in ["show", "check"] {
        let said = |arguments: &[&str]| succeed(folder.path(), &[&["scene", command], arguments].concat()).stdout;
        assert_eq!(said(&["a.toml"]), said(&["--scene", "a.toml"]));
        let both = run(folder.path(), &["scene", command, "a.toml", "--scene", "a.toml"]);
        assert!(both.code == Some(2) && both.stderr.contains("cannot be used with"), "{}", both.stderr);
    }
    assert_eq!(run(folder.path(), &["scene", "check"]).code, Some(2));
    for command in ["render", "spectrum"] {
        let help = succeed(folder.path(), &[command, "--help"]).stdout;
        let flags: Vec<_> = help.lines().filter_map(|line| line.trim().strip_prefix("--")?.split(' ').next()).collect();
        let at = flags.iter().position(|flag| *flag == "place").expect("--place");
        assert_eq!(flags[at + 1], "time", "{flags:?}");
    }
}

#[test]
fn completions_and_manual_name_every_command_and_flag() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = succeed(folder.path(), &["completions", shell]).stdout;
        for word in ["render", "sequence", "spectrum", "sun-elevation", "place", "frames"] {
            assert!(script.contains(word), "{shell}: no {word}");
        }
    }
    let manual = succeed(folder.path(), &["man"]).stdout;
    for word in [".TH sorairo 1", "sorairo\\-render", "sorairo\\-scene"] {
        assert!(manual.contains(word), "no {word} in {manual}");
    }
    let render = succeed(folder.path(), &["man", "render"]).stdout;
    for word in ["sorairo\\-render", "\\-\\-sun\\-elevation", "Elevation of the sun above the horizon (degrees)"] {
        assert!(render.contains(word), "no {word} in {render}");
    }
    assert!(refusal(folder.path(), &["man", "moon"])[0].contains("render, sequence, spectrum"));
    assert_eq!(run(folder.path(), &["completions", "moon"]).code, Some(2));
}
