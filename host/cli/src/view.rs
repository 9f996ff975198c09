//! The command that opens the window.

#[cfg(feature = "view")]
use sorairo::low_level::device;

use crate::arguments::ViewArguments;
use crate::error::Result;
#[cfg(feature = "view")]
use crate::memory;

/// `sorairo view`.
#[cfg(feature = "view")]
pub fn run(arguments: &ViewArguments) -> Result<()> {
    let device = &memory::device(&arguments.scene.device)?;
    let options = sorairo_view::Options {
        scene: arguments.scene.scene()?,
        device,
        point: arguments.click,
        screenshot: arguments.screenshot.as_deref(),
        frames: arguments.frames,
    };
    if let Some((frames, time)) = sorairo_view::open(options, || device::open(device))? {
        let seconds = time.as_secs_f64();
        println!("{frames} skies in {seconds:.2} s: {:.1} a second", f64::from(frames) / seconds);
    }
    Ok(())
}

/// `sorairo view` without its window.
#[cfg(not(feature = "view"))]
pub fn run(_: &ViewArguments) -> Result<()> {
    Err(crate::error::Error::request("this build of sorairo has no window; build it with `--features view`"))
}
