//! One aerosol of several.

use std::sync::Arc;

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};

use super::aeronet::{Aeronet, Derived};
use super::clean_country::CLEAN_COUNTRY;
use super::files::{ExtinctionRows, RefractiveIndex, SizeDistribution};
use super::values::{AerosolProfile, ModeAlbedo, PhaseFunction};
use crate::error::{Error, Result, check_range};
use crate::medium::aerosol::{self, AerosolKind, Layer, Optics, Scattering};
use crate::medium::profile::Profile;
use crate::spectra::choice::AlbedoSpectrum;
use crate::spectra::columns_file::FileOf;
use crate::spectra::named_file::NamedFile;

/// One aerosol of several: what is not said is that of its kind; without a kind, that of the aerosol of clean country
/// in numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct AerosolMode {
    /// Kind of aerosol: one of the words of `atmosphere.aerosol.kind`.
    pub kind: AerosolKind,
    /// Aerosol that AERONET derived from the sky, in place of a kind: the `.pfn` of an inversion of version 2 or 3,
    /// which holds phase functions, or the `.siz`, the `.all` or the `.dubovik`, whose size distribution scatters as
    /// spheres by Mie theory. Files of the same name beside it supply optical depth (`.aod`, `.aot2`, `.cad`), albedo
    /// (`.ssa`) and refractive index (`.rin`). Of several rows the one nearest to `sun.time` is taken, within a day, or
    /// that of `FILE@HH:MM:SS` or `FILE@YYYY-MM-DDTHH:MM:SS` (UTC).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aeronet: Option<Aeronet>,
    /// Size distribution of spheres, in place of a kind: a file of `radius_um,dv_dlnr`, 0.001 to 50 µm; straight over
    /// the logarithm of the radius. Mie theory makes extinction, albedo and phase function of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_distribution: Option<FileOf<SizeDistribution>>,
    /// Refractive index of these spheres: a file of `wavelength_nm,n,k`; straight between wavelengths, constant beyond.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refractive_index: Option<FileOf<RefractiveIndex>>,
    /// Vertical optical depth at the reference wavelength, 0 to 1000. Default: OPAC's value for the kind at 550 nm, or
    /// that of AERONET's files, or that of the size distribution in µm³/µm².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub optical_depth: Option<f64>,
    /// Wavelength of the optical depth (nm). Default: 550.
    pub reference_wavelength: f64,
    /// Ångström exponent of the extinction, -5 to 5. Default: the spectrum of the kind, or 1.3.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angstrom_exponent: Option<f64>,
    /// Extinction by wavelength in place of the exponent: a file of `wavelength_nm,extinction`, in any unit;
    /// extrapolated as a power of the wavelength.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extinction: Option<FileOf<ExtinctionRows>>,
    /// Single-scattering albedo: a number, a kind, `mars-dust` or a file of `wavelength_nm,albedo`. Default: that of
    /// the kind, or 0.972.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub single_scattering_albedo: Option<ModeAlbedo>,
    /// Asymmetry of the phase function of Cornette and Shanks, -0.9 to 0.99. Default: 0.709.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub asymmetry: Option<f64>,
    /// Phase function: `cornette-shanks`, a kind, or a file with `angle_deg` and one column per wavelength, whose name
    /// is the wavelength in nm. Default: that of the kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_function: Option<PhaseFunction>,
    /// Density over the altitude above the ground: a scale height (km), `[bottom, top]` (km), or a file of
    /// `altitude_km,density`. Default: the layers of the kind, or 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<AerosolProfile>,
}

impl Default for AerosolMode {
    fn default() -> Self {
        Self {
            kind: AerosolKind::Plain,
            aeronet: None,
            size_distribution: None,
            refractive_index: None,
            optical_depth: None,
            reference_wavelength: 550.0,
            angstrom_exponent: None,
            extinction: None,
            single_scattering_albedo: None,
            asymmetry: None,
            phase_function: None,
            profile: None,
        }
    }
}

impl AerosolMode {
    /// The files that it reads: each one's name and the CRC-32 of what it holds.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&NamedFile, u32)> {
        let extinction = self.extinction.iter().map(|file| (&file.file, file.checksum));
        let albedo = match &self.single_scattering_albedo {
            Some(ModeAlbedo::File(file)) => Some((&file.file, file.checksum)),
            _ => None,
        };
        let phase = match &self.phase_function {
            Some(PhaseFunction::File(file)) => Some((&file.file, file.checksum)),
            _ => None,
        };
        let profile = match &self.profile {
            Some(AerosolProfile::File(file)) => Some((&file.file, file.checksum)),
            _ => None,
        };
        let aeronet = self.aeronet.iter().flat_map(|aeronet| aeronet.files.iter().zip(aeronet.checksums().to_vec()));
        let sizes = self.size_distribution.iter().map(|file| (&file.file, file.checksum));
        let index = self.refractive_index.iter().map(|file| (&file.file, file.checksum));
        aeronet.chain(sizes).chain(index).chain(extinction).chain(albedo).chain(phase).chain(profile)
    }

    /// Their names, to be changed.
    pub(crate) fn names_mut(&mut self) -> impl Iterator<Item = &mut NamedFile> {
        let extinction = self.extinction.iter_mut().map(|file| &mut file.file);
        let albedo = match &mut self.single_scattering_albedo {
            Some(ModeAlbedo::File(file)) => Some(&mut file.file),
            _ => None,
        };
        let phase = match &mut self.phase_function {
            Some(PhaseFunction::File(file)) => Some(&mut file.file),
            _ => None,
        };
        let profile = match &mut self.profile {
            Some(AerosolProfile::File(file)) => Some(&mut file.file),
            _ => None,
        };
        let aeronet = self.aeronet.iter_mut().flat_map(|aeronet| &mut aeronet.files);
        let sizes = self.size_distribution.iter_mut().map(|file| &mut file.file);
        let index = self.refractive_index.iter_mut().map(|file| &mut file.file);
        aeronet.chain(sizes).chain(index).chain(extinction).chain(albedo).chain(phase).chain(profile)
    }

    /// What its files say of it.
    fn derived(&self) -> Option<std::result::Result<Derived, String>> {
        match (&self.aeronet, &self.size_distribution, &self.refractive_index) {
            (Some(aeronet), ..) => Some(aeronet.derived().cloned()),
            (None, Some(sizes), Some(index)) => Some(Ok(Optics::clone(&sizes.value.optics(index)).into())),
            _ => None,
        }
    }

    /// What the kernels take of it, in air of a profile.
    pub(super) fn optics(&self, profile: &Profile) -> aerosol::Mode {
        let known = self.kind.known();
        let usual = self.kind.usual();
        let exponent = self.angstrom_exponent.unwrap_or(CLEAN_COUNTRY.angstrom_exponent);
        let asymmetry = self.asymmetry.unwrap_or(CLEAN_COUNTRY.asymmetry);
        let grey = |albedo| aerosol::Albedo::Spectrum(AlbedoSpectrum::Grey, albedo);
        let of_kind = |kind: AerosolKind| kind.known().expect("a kind that is named has optics");
        let derived = self.derived().and_then(std::result::Result::ok);
        let depths = derived.as_ref().and_then(|derived| derived.extinction.as_ref().ok());
        let derived_depth = depths.map(|rows| aerosol::Extinction::at(rows, self.reference_wavelength));
        aerosol::Mode {
            depth: self.optical_depth.or(derived_depth).or(usual.as_ref().map(|(depth, _)| *depth)).unwrap_or(0.0),
            reference: self.reference_wavelength,
            extinction: match (&self.extinction, self.angstrom_exponent, depths, known) {
                (Some(file), ..) => aerosol::Extinction::Rows(Arc::clone(&file.value.0)),
                (None, None, Some(rows), _) => aerosol::Extinction::Rows(Arc::clone(rows)),
                (None, None, None, Some(kind)) => aerosol::Extinction::Kind(kind),
                (None, ..) => aerosol::Extinction::Power(exponent),
            },
            albedo: match (&self.single_scattering_albedo, known) {
                (Some(ModeAlbedo::Grey(albedo)), _) => grey(*albedo),
                (Some(ModeAlbedo::MarsDust), _) => aerosol::Albedo::Spectrum(AlbedoSpectrum::MarsDust, 1.0),
                (Some(ModeAlbedo::Kind(kind)), _) => aerosol::Albedo::Kind(of_kind(*kind)),
                (Some(ModeAlbedo::File(file)), _) => aerosol::Albedo::Rows(Arc::new(file.value.0.clone())),
                (None, Some(kind)) => aerosol::Albedo::Kind(kind),
                (None, None) => match derived.as_ref().and_then(|derived| derived.albedo.as_ref().ok()) {
                    Some(albedo) => aerosol::Albedo::Rows(Arc::clone(albedo)),
                    None => grey(CLEAN_COUNTRY.single_scattering_albedo),
                },
            },
            scattering: match (&self.phase_function, self.asymmetry, &derived, known) {
                (Some(PhaseFunction::File(file)), ..) => Scattering::Tabulated(file.value.clone()),
                (Some(PhaseFunction::Kind(kind)), ..) => Scattering::Tabulated(of_kind(*kind).phase().clone()),
                (None, None, Some(derived), _) => Scattering::Tabulated(Arc::clone(&derived.phase)),
                (None, None, None, Some(kind)) => Scattering::Tabulated(kind.phase().clone()),
                (Some(PhaseFunction::CornetteShanks) | None, ..) => Scattering::CornetteShanks(asymmetry),
            },
            layer: match (&self.profile, usual) {
                (Some(AerosolProfile::ScaleHeight(height)), _) => Layer::Exponential(*height),
                (Some(AerosolProfile::Between([bottom, top])), _) => Layer::even(*bottom, *top),
                (Some(AerosolProfile::File(file)), _) => (*file.value).clone(),
                (None, Some((_, layer))) if profile.is_measured() => layer,
                (None, _) => Layer::Exponential(CLEAN_COUNTRY.scale_height),
            },
        }
    }

    /// Checks its values.
    pub(super) fn check(&self) -> Result<()> {
        const KEY: &str = "atmosphere.aerosol";
        let numbers = [
            ("optical_depth", self.optical_depth, (0.0, 1000.0), ""),
            ("reference_wavelength", Some(self.reference_wavelength), (200.0, 4000.0), " nm"),
            ("angstrom_exponent", self.angstrom_exponent, (-5.0, 5.0), ""),
            ("asymmetry", self.asymmetry, (-0.9, 0.99), ""),
        ];
        let not_allowed = |complaint: String| Err(Error::not_allowed(KEY, complaint));
        for (name, number, (low, high), unit) in numbers {
            if number.is_some_and(|number| check_range(KEY, number, (low, high), "").is_err()) {
                let number = number.expect("there is one");
                return not_allowed(format!(
                    "has a mode whose {name} is {number}; it must lie between {low} and {high}{unit}"
                ));
            }
        }
        match (&self.single_scattering_albedo, &self.profile) {
            (Some(ModeAlbedo::Grey(albedo)), _) if !(0.0..=1.0).contains(albedo) => not_allowed(format!(
                "has a mode whose single_scattering_albedo is {albedo}; it must lie between 0 and 1"
            )),
            (_, Some(AerosolProfile::ScaleHeight(height))) if !(0.05..=100.0).contains(height) => not_allowed(format!(
                "has a mode whose profile is {height}; a scale height must lie between 0.05 and 100 km"
            )),
            (_, Some(AerosolProfile::Between([bottom, top]))) if !(*bottom >= 0.0 && top - bottom >= 0.5) => {
                not_allowed(format!(
                    "has a mode whose profile is [{bottom}, {top}]; a layer is 0.5 km thick or more, above the ground"
                ))
            }
            _ => self.check_source().map_err(|complaint| Error::not_allowed(KEY, complaint)),
        }
    }

    /// Whether it says whence its optics come, once.
    fn check_source(&self) -> std::result::Result<(), String> {
        if self.size_distribution.is_some() != self.refractive_index.is_some() {
            return Err("has a mode with one of size_distribution and refractive_index; both make spheres".into());
        }
        let sources = [
            ("kind", self.kind != AerosolKind::Plain),
            ("aeronet", self.aeronet.is_some()),
            ("size_distribution", self.size_distribution.is_some()),
        ];
        let said: Vec<_> = sources.iter().filter(|(_, is_said)| *is_said).map(|(name, _)| *name).collect();
        if said.len() > 1 {
            return Err(format!("has a mode with {}; one of them describes it", said.join(" and ")));
        }
        match self.derived() {
            Some(Err(complaint)) => Err(format!("has a mode from {complaint}")),
            Some(Ok(derived)) => self.check_derived(&derived),
            None if said.is_empty() && self.optical_depth.is_none() => {
                Err("has a mode with neither a kind nor an optical_depth".into())
            }
            None => Ok(()),
        }
    }

    /// Whether its files hold what it does not say.
    fn check_derived(&self, derived: &Derived) -> std::result::Result<(), String> {
        let depth = derived.extinction.as_ref().err().filter(|_| self.optical_depth.is_none());
        let albedo = derived.albedo.as_ref().err().filter(|_| self.single_scattering_albedo.is_none());
        depth.or(albedo).map_or(Ok(()), |complaint| Err(format!("has a mode from {complaint}")))
    }
}
