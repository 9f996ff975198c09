//! What a given key implies for others, which the preset has filled in.
//!
//! A preset of measured air also holds values of closed-form air and of plain aerosol. A scene that gives one of these,
//! and no profile or kind, selects the air or the aerosol that it describes. So does a ground or a top outside the
//! range of the measured profile.

use super::aerosol::CLEAN_COUNTRY;
use super::preset::Scene;
use super::rules::LOWEST_TOP_OF_A_PROFILE;
use crate::medium::aerosol::AerosolKind;
use crate::medium::profile::Profile;

/// Keys of air and ozone in closed form.
const CLOSED_FORM: [&str; 4] =
    ["atmosphere.air.scale_height", "atmosphere.ozone.bottom", "atmosphere.ozone.peak", "atmosphere.ozone.top"];

/// Keys of plain aerosol.
const PLAIN: [&str; 4] = [
    "atmosphere.aerosol.angstrom_exponent",
    "atmosphere.aerosol.single_scattering_albedo",
    "atmosphere.aerosol.single_scattering_albedo_spectrum",
    "atmosphere.aerosol.asymmetry",
];

impl Scene {
    /// Fills in profile, refraction, kind and optical depth of aerosol where no key says them, by the keys that were
    /// said over the preset.
    pub(super) fn imply(&mut self, is_said: impl Fn(&str) -> bool) {
        let preset = Self::preset(self.preset);
        let has_said = |keys: &[&str]| keys.iter().any(|key| is_said(key));
        let is_on_earth = self.is_on_earth();
        let atmosphere = &mut self.atmosphere;
        let depth = atmosphere.top_radius - atmosphere.ground_radius;
        if !is_said("atmosphere.profile") {
            let is_described = has_said(&CLOSED_FORM) || !is_on_earth || depth < LOWEST_TOP_OF_A_PROFILE;
            atmosphere.profile = if is_described { Profile::Exponential } else { preset.atmosphere.profile.clone() };
        }
        if !is_said("atmosphere.refraction") {
            atmosphere.refraction = preset.atmosphere.refraction && atmosphere.profile.is_measured() && is_on_earth;
        }
        if is_said("atmosphere.aerosol.modes") {
            return;
        }
        if !is_said("atmosphere.aerosol.kind") {
            let described = has_said(&PLAIN).then_some(AerosolKind::Plain);
            atmosphere.aerosol.kind = described.unwrap_or(preset.atmosphere.aerosol.kind);
        }
        if !is_said("atmosphere.aerosol.optical_depth") {
            let is_plain = atmosphere.aerosol.kind == AerosolKind::Plain;
            let of_kind = preset.atmosphere.aerosol.kind != AerosolKind::Plain;
            let preset = preset.atmosphere.aerosol.optical_depth;
            atmosphere.aerosol.optical_depth = if is_plain && of_kind { CLEAN_COUNTRY.optical_depth } else { preset };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Preset;

    fn read(text: &str) -> Scene {
        Scene::parse(text, "a.toml", Some(Preset::Standard)).unwrap()
    }

    #[test]
    fn numbers_of_closed_forms_take_the_place_of_what_was_measured() {
        let standard = read("").atmosphere;
        assert!(standard.profile.is_measured() && standard.refraction && standard.aerosol.kind != AerosolKind::Plain);
        for text in ["air.scale_height = 8.0", "ozone.peak = 24.0", "ground_radius = 3390.0", "top_radius = 6400.0"] {
            let found = read(&format!("[atmosphere]\n{text}\n")).atmosphere;
            assert_eq!((found.profile, found.refraction), (Profile::Exponential, false), "{text}");
            assert_eq!(found.aerosol.kind, standard.aerosol.kind, "{text}");
        }
        let plain = read("atmosphere.aerosol.asymmetry = 0.7").atmosphere;
        assert_eq!(plain.aerosol.kind, AerosolKind::Plain);
        assert_eq!(plain.profile, standard.profile);
    }

    #[test]
    fn what_is_said_stands() {
        let text = "[atmosphere]\nprofile = 'tropical'\nair.scale_height = 7.0\naerosol = { kind = 'desert', asymmetry = 0.7 }";
        let said = read(text).atmosphere;
        assert_eq!((said.profile, said.refraction), (Profile::Tropical, true));
        assert_eq!(said.aerosol.kind, AerosolKind::Desert);
        // Air without a slope that is known bends nothing.
        assert!(!read("atmosphere.profile = 'exponential'").atmosphere.refraction);
        assert!(!read("atmosphere.refraction = false").atmosphere.refraction);
        // Presets in closed form imply nothing.
        let earth = Scene::parse("preset = 'earth'\natmosphere.profile = 'us-standard'", "a.toml", None).unwrap();
        assert!(!earth.atmosphere.refraction);
    }
}
