//! Azimuths as people say them: any finite number of degrees, of which whole turns are nothing.

use crate::error::{Error, Result};

/// What the azimuth of a name means (degrees): itself, without whole turns.
///
/// # Errors
///
/// [`Error::NotAllowed`] if it is not finite.
pub fn within_a_turn(key: &'static str, azimuth: f64) -> Result<f64> {
    match azimuth.is_finite() {
        true => Ok(azimuth % 360.0),
        false => Err(Error::not_allowed(key, format!("is {azimuth}; an azimuth is a finite number of degrees"))),
    }
}
