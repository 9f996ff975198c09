//! One image: a sky as a picture to look at and as linear light for a renderer.
//!
//! ```sh
//! cargo run --release --package sorairo --example image -- sky
//! ```
//!
//! writes `sky.png` and `sky.exr`.

use sorairo::scene::Projection;
use sorairo::{Device, Preset, Scene, Sky};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).ok_or("usage: image NAME")?;
    let mut scene = Scene::preset(Preset::Hazy);
    scene.sun.elevation = 8.0;
    scene.sun.azimuth = 250.0;
    scene.camera.projection = Projection::Fisheye;
    scene.camera.size = "512x512".parse()?;
    let mut device = Device::open("auto")?;
    let image = Sky::new(&scene)?.image(&scene.camera, &mut device)?;
    image.save(format!("{name}.png"))?;
    image.save(format!("{name}.exr"))?;
    let [red, green, blue] = image.pixel(256, 256);
    println!("{}: the zenith is {red:.3}, {green:.3}, {blue:.3} W.m-2.sr-1", device.name);
    Ok(())
}
