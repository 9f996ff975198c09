//! The command that opens the window.

use crate::arguments::ViewArguments;
use crate::error::Result;
#[cfg(feature = "view")]
use crate::{memory, output::print_line};

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
    if let Some(sorairo_view::Counted { skies, size, time, longest, pipelines, drawn, read_back }) =
        sorairo_view::open(options, || sorairo::Device::open(device))?
    {
        let longest = longest.as_secs_f64() * 1e3;
        let (seconds, rate) = (time.as_secs_f64(), f64::from(skies) / time.as_secs_f64());
        let line = if arguments.json {
            let count = serde_json::json!({
                "skies": skies, "size": size.to_string(), "seconds": seconds, "skies_per_second": rate,
                "longest_ms": longest,
                "pipelines": pipelines,
                "drawn_in_place": drawn, "read_back": read_back,
            });
            count.to_string()
        } else {
            format!(
                "{skies} skies of {size} in {seconds:.2} s: {rate:.1} a second, the longest {longest:.0} ms; {drawn} drawn in place, {read_back} read back"
            )
        };
        print_line(&line)?;
    }
    Ok(())
}

/// `sorairo view` without its window.
#[cfg(not(feature = "view"))]
pub fn run(_: &ViewArguments) -> Result<()> {
    Err(crate::error::Error::request(
        "this sorairo has no window; `cargo install sorairo-cli --features view` gives one that has",
    ))
}
