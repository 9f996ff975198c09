//! What a process does whose address space is limited, as by `ulimit -v`.
//!
//! Where memory runs out Rust and the compilers of drivers say so and abort, and drivers that forget to ask crash. So
//! no driver is opened where it may not fit, and an abort ends the process as a failure. What no process can tell: that
//! it does not fit itself (about 60 MB, which the loader says or dies of), a stack that cannot grow, and a kernel that
//! ends processes because the machine has no memory left.

use std::borrow::Cow;

use crate::error::{Error, Result};

/// The address space that the drivers of a device may take (bytes). Mesa's llvmpipe takes .6 to 1.1 GB and crashes in
/// between now and then; drivers of hardware map the device's memory as well.
const OF_DRIVERS: u64 = 2 << 30;

/// Lets an abort for want of memory end the process with the exit code of a failure, where memory is limited. The
/// reason is told before.
pub fn fail_at_the_limit() {
    #[cfg(unix)]
    if limit().is_some() {
        use signal_hook::{consts::SIGABRT, flag::register_conditional_shutdown};
        // Without it the process ends as it would.
        let _ = register_conditional_shutdown(SIGABRT, 1, std::sync::Arc::new(true.into()));
    }
}

/// The device to open for the one that was asked for: with `auto` the CPU where drivers may not fit.
///
/// # Errors
///
/// Another device than the CPU where its drivers may not fit.
pub fn device(asked: &str) -> Result<Cow<'_, str>> {
    let small = limit().filter(|&limit| limit < OF_DRIVERS);
    let Some(limit) = small.filter(|_| !asked.eq_ignore_ascii_case("cpu")) else { return Ok(asked.into()) };
    let why = format!(
        "the address space is limited to {} MB (ulimit -v), and drivers of Vulkan devices may take {} MB",
        limit >> 20,
        OF_DRIVERS >> 20
    );
    if asked.eq_ignore_ascii_case("auto") {
        log::warn!("{why}; rendering on the CPU");
        return Ok("cpu".into());
    }
    Err(Error::Failure(format!("--device {asked}: {why}; --device cpu needs none")))
}

/// The limit of the address space (bytes), if there is one.
#[cfg(unix)]
fn limit() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::As).current
}

/// The limit of the address space, which is not known here.
#[cfg(not(unix))]
fn limit() -> Option<u64> {
    None
}
