//! Times the CPU in turn with another program: for each line of standard input, `table` or `direct`, computes the image
//! that it names once more, by the sky lookup or by the integral at every pixel, and prints the milliseconds that its
//! kernels took.
//!
//! ```sh
//! yes table | head -9 | cargo run --release --package sorairo --example turns -- 1920x960
//! ```
//!
//! The sky is the preset `standard` in light of all orders over black ground, of which the upper half of the image is
//! seen. `tests/python/beside_sunsky.py` drives it.

use std::io::BufRead;

use sorairo::low_level::device::{Backend, cpu::Cpu};
use sorairo::scene::{GroundAlbedo, PathChoice};
use sorairo::{PixelFormat, Plan, Preset, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::preset(Preset::Standard);
    scene.camera.size = std::env::args().nth(1).ok_or("usage: turns WxH")?.parse()?;
    scene.ground.albedo = GroundAlbedo::Grey(0.0);
    let mut planned = |path| {
        scene.render.path = path;
        Ok::<_, sorairo::Error>(Plan::new(&scene.validated()?, PixelFormat::LinearRgb))
    };
    let (table, direct) = (planned(PathChoice::Lookup)?, planned(PathChoice::Direct)?);
    for line in std::io::stdin().lock().lines() {
        let plan = match line?.as_str() {
            "table" => &table,
            "direct" => &direct,
            other => return Err(format!("a line is table or direct, not {other:?}").into()),
        };
        println!("{}", Cpu.run(plan, plan.kernel())?.kernel.as_secs_f64() * 1e3);
    }
    Ok(())
}
