//! Memory, asked for before it is needed: an allocation that fails inside a computation ends the process.

use std::fs::read_to_string;

use sorairo::{Error, Result};

/// What a computation takes beside its result, whatever is asked (bytes): the light fields that are kept, and the
/// threads.
const BESIDE: usize = 192 << 20;

/// What it takes at most for each wavelength (bytes): where each is integrated, a lookup of light that was scattered
/// more than once, twice while it is made. Measured: 59 KiB in twilight on the ground, 24 by day, less than 3 by the
/// fit.
const A_WAVELENGTH: usize = 128 << 10;

/// An array of this shape, empty yet, if there is room for it and for the computation of what it holds: so many bytes
/// beside, at most.
///
/// # Errors
///
/// [`Error::Memory`] if there is none.
pub fn array<T>(shape: &[usize], beside: usize) -> Result<Vec<T>> {
    let mut array = Vec::new();
    let length = shape.iter().copied().fold(1, usize::saturating_mul);
    let all = length.saturating_mul(size_of::<T>()).saturating_add(beside);
    let is_free = free().is_none_or(|free| all <= free);
    let is_allowed = || Vec::<u8>::new().try_reserve_exact(all.saturating_add(BESIDE)).is_ok();
    if is_free && is_allowed() && array.try_reserve_exact(length).is_ok() {
        return Ok(array);
    }
    let shape: Vec<String> = shape.iter().map(ToString::to_string).collect();
    Err(Error::Memory(format!("an array of {} values does not fit into memory", shape.join(" x "))))
}

/// What spectra at so many wavelengths take (bytes).
pub fn of_wavelengths(count: usize) -> usize {
    count.saturating_mul(A_WAVELENGTH)
}

/// The memory that the system would still give (bytes), where it tells. It promises more than it has, and ends who
/// takes it.
fn free() -> Option<usize> {
    let of_group = read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    let of_machine = read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()?.checked_mul(1024)
    });
    of_group.into_iter().chain(of_machine).min()
}
