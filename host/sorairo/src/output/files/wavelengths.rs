//! The wavelengths that spectral files hold.

use super::format::Format;
use super::radiance_picture;
use crate::error::{Error, Result};
use crate::input::shown;
use crate::scene::Scene;

/// Most wavelengths of a spectral file.
pub const MOST_WAVELENGTHS: usize = 512;

/// Wavelengths (nm) closer than this have the same name in a spectral EXR.
const CLOSEST_WAVELENGTHS: f64 = 1e-5;

/// Wavelengths (nm) of spectral files of these formats, if none are asked for: 390 to 770 by 20 where one is of
/// Radiance, 380 to 780 by 10 elsewhere.
pub fn default_wavelengths(formats: &[Format]) -> Vec<f64> {
    let (first, step, count) = if formats.contains(&Format::RadiancePicture) { (390, 20, 20) } else { (380, 10, 41) };
    (0..count).map(|i| f64::from(first + step * i)).collect()
}

/// The wavelengths (nm, increasing) of the spectral files among these formats; none if no format is one. `every_exr`
/// says that every EXR file was to be spectral.
///
/// # Errors
///
/// [`Error::NoSpectralFile`] if there is no such file and something was asked of it; [`Error::NotAllowed`] for
/// wavelengths that the files cannot hold, or at which the scene is not known.
pub fn wavelengths(scene: &Scene, asked: Option<&[f64]>, every_exr: bool, formats: &[Format]) -> Result<Vec<f64>> {
    if !formats.iter().any(|format| format.is_spectral()) {
        return match asked {
            _ if every_exr => Err(Error::NoSpectralFile { key: "spectral" }),
            Some(_) => Err(Error::NoSpectralFile { key: "wavelengths" }),
            None => Ok(Vec::new()),
        };
    }
    let mut wavelengths = asked.map_or_else(|| default_wavelengths(formats), <[f64]>::to_vec);
    let refuse = |complaint| Err(Error::not_allowed("wavelengths", complaint));
    let count = wavelengths.len();
    if !(1..=MOST_WAVELENGTHS).contains(&count) {
        return refuse(format!("holds {count} wavelengths; a spectral file takes 1 to {MOST_WAVELENGTHS} of them"));
    }
    let (shortest, longest) = scene.known_wavelengths();
    if let Some(outside) = wavelengths.iter().find(|&&nm| !(shortest..=longest).contains(&nm)) {
        return refuse(format!("holds {}; wavelengths must lie between {shortest} and {longest} nm", shown(*outside)));
    }
    wavelengths.sort_by(f64::total_cmp);
    if let Some(pair) = wavelengths.windows(2).find(|pair| pair[1] - pair[0] < CLOSEST_WAVELENGTHS) {
        return refuse(format!(
            "holds {} and {}; wavelengths must lie at least {CLOSEST_WAVELENGTHS} nm apart",
            pair[0], pair[1]
        ));
    }
    if formats.contains(&Format::RadiancePicture) {
        radiance_picture::check_wavelengths(&wavelengths)?;
    }
    Ok(wavelengths)
}
