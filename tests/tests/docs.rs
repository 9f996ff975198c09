//! What the documents promise.

use std::path::Path;

use sorairo_tests::program::{read_exr, read_png, succeed};

fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

#[test]
fn every_command_of_the_gallery_makes_the_picture_above_it() {
    let page = std::fs::read_to_string(repository().join("docs/gallery.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    for command in page.lines().filter_map(|line| line.strip_prefix("sorairo ")) {
        let arguments: Vec<&str> = command.split(' ').collect();
        succeed(folder.path(), &arguments);
        let name = arguments.last().unwrap();
        assert!(page.contains(&format!("(images/gallery/{name})")), "{name} is not shown");
        let made = read_png(&folder.path().join(name));
        let shown = read_png(&repository().join("docs/images/gallery").join(name));
        assert_eq!((made.width, made.height), (shown.width, shown.height), "{name}");
        // Devices differ by a rounding of the last bit; where the disc ends, by a sample of a pixel.
        let apart = made.rgb.iter().zip(&shown.rgb).filter(|(a, b)| a.abs_diff(**b) > 2).count();
        assert!(apart * 1000 < made.rgb.len(), "{name}: {apart} of {} values differ", made.rgb.len());
        let levels = made.rgb.iter().collect::<std::collections::HashSet<_>>().len();
        assert!(levels > 50, "{name} has {levels} levels: it shows nothing");
        compared += 1;
    }
    assert!(compared >= 10, "{compared} pictures");
}

#[test]
fn every_command_of_the_tutorial_runs() {
    let page = std::fs::read_to_string(repository().join("docs/tutorial.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("sorairo ")).collect();
    assert!(commands.len() >= 10, "{commands:?}");
    for command in commands {
        let (arguments, into) = command.split_once(" > ").unwrap_or((command, ""));
        let ended = succeed(folder.path(), &arguments.split(' ').collect::<Vec<_>>());
        if !into.is_empty() {
            std::fs::write(folder.path().join(into), &ended.stdout).unwrap();
            assert!(ended.stdout.starts_with('{'), "{command}: {}", ended.stdout);
        }
    }
    for made in
        ["sky.png", "sky.exr", "greenwich.png", "evening/sky.0016.png", "evening/contact.png", "sky.spectral.exr"]
    {
        assert!(folder.path().join(made).is_file(), "{made}");
    }
}

/// The example of the README, line by line.
fn example() -> sorairo::Result<()> {
    use sorairo::{Renderer, Scene};

    let mut scene = Scene::default();
    scene.sun.elevation = 10.0;
    let mut renderer = Renderer::open("auto")?;
    let sky = renderer.render(&scene)?;
    sky.save("sky.exr")?;
    Ok(())
}

#[test]
fn the_readmes_example_compiles_and_writes_its_file() {
    let trimmed = |text: &str| text.lines().map(str::trim).collect::<Vec<_>>().join("\n");
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let shown = readme.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    assert!(
        trimmed(include_str!("docs.rs")).contains(trimmed(shown).trim()),
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
