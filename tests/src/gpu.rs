//! The GPU of the tests: without one they fail, and never skip.

use std::sync::LazyLock;

use sorairo::Device;
use sorairo::low_level::device::Backend;
use sorairo::low_level::device::gpu::Gpu;

/// The best Vulkan device of this machine, opened once for all tests of a process.
///
/// # Panics
///
/// If there is none; the words say what to install.
pub fn device() -> &'static Device {
    static GPU: LazyLock<Device> = LazyLock::new(|| limited(u64::MAX).into_device());
    &GPU
}

/// What runs its kernels.
///
/// # Panics
///
/// As [`device`].
pub fn backend() -> &'static dyn Backend {
    &*device().backend
}

/// The same device opened anew, as if it took no buffer larger than this (bytes).
///
/// # Panics
///
/// As [`device`].
pub fn limited(largest_buffer: u64) -> Gpu {
    let opened = Gpu::open("").unwrap_or_else(|error| panic!("the Vulkan device does not open: {error}"));
    let gpu = opened.expect("a Vulkan device; on Debian: apt-get install mesa-vulkan-drivers libvulkan1");
    gpu.with_largest_buffer(largest_buffer)
}
