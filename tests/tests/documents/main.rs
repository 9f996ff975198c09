//! What the documents promise.

use std::path::{Path, PathBuf};

use clap::Parser;
use sorairo_cli::arguments::Arguments;
use sorairo_tests::program::{read_exr, read_png, run, succeed};

#[path = "../../../xtask/src/pages.rs"]
mod pages;

fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Every page of the repository, with its place and its text.
fn pages_for_people() -> Vec<(PathBuf, String)> {
    let mut pages = Vec::new();
    let mut folders = vec![repository().to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() && !name.starts_with('.') && name != "target" {
                folders.push(path);
            } else if name.ends_with(".md") {
                let text = std::fs::read_to_string(&path).unwrap();
                pages.push((path, text));
            }
        }
    }
    assert!(pages.len() >= 20, "{} pages", pages.len());
    pages
}

/// The anchors of a page's headings, as GitHub makes them.
fn anchors(page: &str) -> Vec<String> {
    let anchor = |heading: &str| {
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.collect::<String>().to_lowercase().replace(' ', "-")
    };
    page.lines().filter(|line| line.starts_with('#')).map(|line| anchor(line.trim_start_matches('#').trim())).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut followed = 0;
    for (page, text) in pages_for_people() {
        let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for link in links.filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            assert!(target.exists(), "{}: {link} leads nowhere", page.display());
            let found =
                anchor.is_empty() || anchors(&std::fs::read_to_string(&target).unwrap()).contains(&anchor.into());
            assert!(found, "{}: {link} names no heading", page.display());
            followed += 1;
        }
    }
    assert!(followed >= 50, "{followed} links");
}

/// What a text names in backticks that looks like a file or a folder of the repository.
fn paths_named(text: &str) -> impl Iterator<Item = &str> {
    let prose = text.split("```").step_by(2);
    let quoted = prose.flat_map(|part| part.split('`').skip(1).step_by(2));
    let roots = ["docs/", "fuzz/", "host/", "shader-crate/", "shared/", "tests/", "xtask/"];
    quoted.filter(move |quoted| roots.iter().any(|root| quoted.starts_with(root)) && !quoted.contains(' '))
}

#[test]
fn every_file_that_a_page_names_exists() {
    let mut named = 0;
    for (page, text) in pages_for_people() {
        for path in paths_named(&text) {
            assert!(repository().join(path).exists(), "{}: there is no {path}", page.display());
            named += 1;
        }
    }
    assert!(named >= 20, "{named} files");
}

#[test]
fn every_line_of_the_map_names_what_exists() {
    let page = std::fs::read_to_string(repository().join("ARCHITECTURE.md")).unwrap();
    let map = page.split("## The map\n\n```\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a map");
    let mut folder = "";
    for line in map.lines() {
        let name = line.split_whitespace().next().expect("a name");
        let path = if line.starts_with(' ') { repository().join(folder).join(name) } else { repository().join(name) };
        assert!(path.exists(), "the map of ARCHITECTURE.md has {}, which is not there", path.display());
        if !line.starts_with(' ') {
            folder = name;
        }
    }
    assert!(map.lines().count() >= 30, "{map}");
    let shared = std::fs::read_dir(repository().join("shared/src")).unwrap();
    for file in shared.map(|entry| entry.unwrap().file_name().into_string().unwrap()) {
        assert!(file == "lib.rs" || map.contains(&format!("  {file} ")), "the map lacks shared/src/{file}");
    }
}

/// The lines of a page's blocks of commands: those fenced without a language.
fn code(page: &str) -> impl Iterator<Item = &str> {
    let mut fence = None;
    page.lines().filter(move |line| {
        match (fence, line.strip_prefix("```")) {
            (None, Some(language)) => fence = Some(language),
            (Some(_), Some(_)) => fence = None,
            _ => {}
        }
        fence == Some("") && *line != "```"
    })
}

#[test]
fn every_command_of_a_page_is_one_of_the_program() {
    let mut parsed = 0;
    for (page, text) in pages_for_people() {
        let commands = code(&text).filter_map(|line| {
            let line = line.strip_prefix("$ ").unwrap_or(line);
            line.strip_prefix("cargo run --release -- ").or_else(|| line.strip_prefix("sorairo "))
        });
        for command in commands.filter(|command| !command.starts_with('-')) {
            let command = command.split(" > ").next().unwrap().split(" # ").next().unwrap();
            let arguments = std::iter::once("sorairo").chain(command.split_whitespace());
            if let Err(error) = Arguments::try_parse_from(arguments) {
                panic!("{}: {command}: {error}", page.display());
            }
            parsed += 1;
        }
    }
    assert!(parsed >= 40, "{parsed} commands");
}

#[test]
fn the_readmes_refusal_is_what_the_program_says() {
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let lines: Vec<&str> = code(&readme).collect();
    let shown: Vec<_> = lines.windows(2).filter(|pair| pair[0].starts_with("$ sorairo ")).collect();
    assert!(!shown.is_empty(), "the README shows no refusal");
    let folder = tempfile::tempdir().unwrap();
    for pair in shown {
        let ended = run(folder.path(), &pair[0].split(' ').skip(2).collect::<Vec<_>>());
        assert_eq!((ended.code, ended.stderr.trim()), (Some(2), pair[1]), "{}", pair[0]);
    }
}

#[test]
fn pages_of_figures_are_what_their_templates_give() {
    let written = pages::pages(repository()).unwrap();
    assert_eq!(written.len(), 3);
    for (path, text) in written {
        let kept = std::fs::read_to_string(repository().join(&path)).unwrap();
        assert!(
            kept == text,
            "{} differs from docs/figures and docs/templates: run `cargo xtask docs`",
            path.display()
        );
    }
}

#[test]
fn every_command_of_the_gallery_makes_the_picture_above_it() {
    let page = std::fs::read_to_string(repository().join("docs/gallery.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    for command in page.lines().filter_map(|line| line.strip_prefix("sorairo ")) {
        let arguments: Vec<&str> = command.split(' ').collect();
        succeed(folder.path(), &arguments);
        let output = arguments.last().unwrap();
        // Of a sequence the contact sheet is shown.
        let name = output.replace("##.png", "contact.png");
        assert!(page.contains(&format!("(images/gallery/{name})")), "{name} is not shown");
        let made = read_png(&folder.path().join(&name));
        let shown = read_png(&repository().join("docs/images/gallery").join(&name));
        assert_eq!((made.width, made.height), (shown.width, shown.height), "{name}");
        // Devices differ by a rounding of the last bit; where the disc ends, by a sample of a pixel.
        let apart = made.rgb.iter().zip(&shown.rgb).filter(|(a, b)| a.abs_diff(**b) > 2).count();
        assert!(apart * 1000 < made.rgb.len(), "{name}: {apart} of {} values differ", made.rgb.len());
        let levels = made.rgb.iter().collect::<std::collections::HashSet<_>>().len();
        assert!(levels > 50, "{name} has {levels} levels: it shows nothing");
        compared += 1;
    }
    assert!(compared >= 12, "{compared} pictures");
}

#[test]
fn the_first_picture_of_the_readme_is_what_the_first_command_makes() {
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let first = readme.split("](").nth(1).and_then(|rest| rest.split(')').next()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &["render", "--device", "cpu"]);
    let [made, shown] = [folder.path().join("sky.png"), repository().join(first)].map(|path| read_png(&path));
    assert_eq!((made.width, made.height), (shown.width, shown.height));
    // Another device may round a byte.
    assert!(made.rgb.iter().zip(&shown.rgb).all(|(a, b)| a.abs_diff(*b) <= 1));
}

/// The numbers of a text, as it writes them.
fn numbers(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !c.is_ascii_digit() && c != '.');
    words.filter(|word| word.starts_with(|c: char| c.is_ascii_digit()))
}

#[test]
fn every_figure_of_the_readme_is_one_of_its_page() {
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let mut found = 0;
    for row in readme.lines().filter(|line| line.starts_with("| ") && line.contains("](docs/")) {
        let cells: Vec<&str> = row.split('|').collect();
        let (_, link) = cells[3].split_once("](").unwrap();
        let page = std::fs::read_to_string(repository().join(link.split(['#', ')']).next().unwrap())).unwrap();
        for figure in numbers(cells[2]) {
            assert!(numbers(&page).any(|number| number == figure), "{link} has no {figure}");
            found += 1;
        }
    }
    assert!(found >= 4, "{found} figures");
}

/// The files that a page shows: their names stand behind the languages of their blocks.
fn files_shown(page: &str) -> impl Iterator<Item = (&str, &str)> {
    page.split("```").skip(1).step_by(2).filter_map(|block| {
        let (head, text) = block.split_once('\n')?;
        Some((head.split_once(' ')?.1, text))
    })
}

#[test]
fn every_command_of_the_tutorial_runs() {
    let page = std::fs::read_to_string(repository().join("docs/tutorial.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("sorairo ")).collect();
    assert!(commands.len() >= 10, "{commands:?}");
    let files: Vec<_> = files_shown(&page).collect();
    assert_eq!(files.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["ozone.csv", "own.toml"]);
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    for command in commands {
        let (arguments, into) = command.split_once(" > ").unwrap_or((command, ""));
        let ended = succeed(folder.path(), &arguments.split(' ').collect::<Vec<_>>());
        if !into.is_empty() {
            std::fs::write(folder.path().join(into), &ended.stdout).unwrap();
            assert!(ended.stdout.starts_with('{'), "{command}: {}", ended.stdout);
        }
    }
    for made in [
        "sky.png",
        "sky.exr",
        "greenwich.png",
        "evening/sky.0016.png",
        "evening/contact.png",
        "sky.spectral.exr",
        "own.png",
    ] {
        assert!(folder.path().join(made).is_file(), "{made}");
    }
}

/// The example of the README, line by line.
fn example() -> sorairo::Result<()> {
    use sorairo::{Device, Direction, Scene, Sky};

    let mut scene = Scene::default();
    scene.sun.elevation = 10.0;
    let sky = Sky::new(&scene)?;
    sky.image(&scene.camera, &mut Device::open("auto")?)?.save("sky.exr")?;
    let zenith = sky.radiance(&[Direction::new(90.0, 0.0)], &[450.0, 550.0, 650.0])?; // [1][3], W·m⁻²·sr⁻¹·nm⁻¹
    assert!(zenith[0][0] > zenith[0][2], "{zenith:?}");
    Ok(())
}

#[test]
fn the_readmes_example_compiles_and_writes_its_file() {
    let trimmed = |text: &str| text.lines().map(str::trim).collect::<Vec<_>>().join("\n");
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let shown = readme.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    assert!(
        trimmed(include_str!("main.rs")).contains(trimmed(shown).trim()),
        "the README shows another example:\n{shown}"
    );
    let folder = tempfile::tempdir().unwrap();
    // No other test here has a relative path.
    std::env::set_current_dir(folder.path()).unwrap();
    example().unwrap();
    let (image, _) = read_exr(&folder.path().join("sky.exr"));
    assert_eq!((image.width, image.height), (1024, 512));
    assert!(image.at(512, 10)[2] > image.at(512, 10)[0], "the sky is not blue");
}
