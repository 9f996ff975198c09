//! The pixels of jobs, and the files that take them.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::Scope;

use sorairo_shared::variant::PixelFormat;

use super::job::{Job, Part};
use crate::device::{Device, Times};
use crate::error::{Error, Result};
use crate::measure::stokes_image::StokesImage;
use crate::output::files::{self, Format, Image, Staged, Sunlight, Writer};
use crate::scene::ValidScene;

/// The files of a job whose pixels are computed.
#[must_use = "files that are not finished are removed"]
pub struct Files<'scope> {
    writers: Vec<Writer<'scope>>,
}

impl Files<'_> {
    /// Waits for the encoders. Every file is whole before the first takes its place, and a failure leaves all of them
    /// as they were.
    ///
    /// # Errors
    ///
    /// [`Error::Write`] if a file cannot be written.
    pub fn finish(self) -> Result<()> {
        files::commit_all(self.staged()?)
    }

    fn staged(self) -> Result<Vec<Staged>> {
        self.writers.into_iter().map(Writer::finish).collect()
    }
}

impl Part {
    /// Begins its files, each encoded on a thread of its own.
    fn begin<'scope>(&self, scope: &'scope Scope<'scope, '_>, scene: &ValidScene) -> Result<Files<'scope>> {
        let plan = &self.plan;
        let mut image = Image::of(plan, scene);
        image.spectra.stokes = self.stokes;
        if self.outputs.iter().any(|(_, format)| format.is_scene()) {
            let sun = self.sun();
            image.sun = Sunlight {
                spectrum: sun.spectral_irradiance(|_| 1.0),
                rgb: plan.sky.plan().sun_irradiance().rgb.to_array(),
                across: sun.across(),
            };
        }
        let begin = |(path, format): &(PathBuf, Format)| Writer::start(scope, path.clone(), *format, image.clone());
        Ok(Files { writers: self.outputs.iter().map(begin).collect::<Result<_>>()? })
    }

    /// Computes the pixels of its files.
    fn fill(&self, files: &Files<'_>, device: &mut Device) -> Result<Times> {
        let plan = &self.plan;
        let spectral = plan.spectral.as_deref();
        let stokes =
            self.stokes.zip(spectral).map(|(frame, spectral)| StokesImage::new(plan.sky.plan(), spectral, frame));
        device.rows(plan, plan.kernel(), &mut |first, rows| {
            check_rows(plan.pixel, rows)?;
            let rows: Arc<[u32]> = match &stokes {
                Some(stokes) => stokes.beside(first, rows).into(),
                None => rows.into(),
            };
            files.writers.iter().try_for_each(|writer| writer.take(Arc::clone(&rows)))
        })
    }
}

/// Computes the pixels of jobs of one sky; their files are encoded meanwhile.
///
/// # Errors
///
/// [`Error::FileExists`] or [`Error::ForeignFile`] if a file that is there must stay; [`Error::Device`] if every device
/// failed, [`Error::NotAllowed`] if the image is too wide for the device, [`Error::Write`] if a file cannot be written.
pub fn compute<'scope>(
    jobs: &[Job],
    scope: &'scope Scope<'scope, '_>,
    device: &mut Device,
) -> Result<(Times, Files<'scope>)> {
    jobs.iter().try_for_each(Job::check_replaced)?;
    let parts: Vec<_> = jobs.iter().flat_map(|job| job.parts.iter().map(|part| (part, &job.scene))).collect();
    let begun: Vec<Files<'_>> = parts.iter().map(|(part, scene)| part.begin(scope, scene)).collect::<Result<_>>()?;
    let mut times = Times::default();
    let filled = parts.iter().zip(&begun).try_for_each(|((part, _), files)| {
        times += part.fill(files, device)?;
        Ok(())
    });
    let files = Files { writers: begun.into_iter().flat_map(|files| files.writers).collect() };
    match filled {
        Ok(()) => {}
        // An encoder that failed knows why.
        Err(error @ Error::Write { .. }) => return Err(files.staged().err().unwrap_or(error)),
        Err(error) => return Err(error),
    }
    Ok((times, files))
}

/// Refuses rows that hold what no kernel stores: the sentinel of a pixel that was never written, or what no radiance
/// is.
fn check_rows(pixel: PixelFormat, rows: &[u32]) -> Result<()> {
    const OPAQUE: u32 = 0xff00_0000;
    const HALF_INFINITY: u32 = 0x7c00;
    let wrong = match pixel {
        PixelFormat::Picture => rows.iter().any(|&word| word & OPAQUE != OPAQUE),
        PixelFormat::LinearRgb | PixelFormat::LinearRgba => rows.iter().any(|&word| {
            let value = f32::from_bits(word);
            !(value.is_finite() && value >= 0.0)
        }),
        PixelFormat::HalfRgb => rows.iter().any(|&word| word & 0xffff >= HALF_INFINITY || word >> 16 >= HALF_INFINITY),
    };
    if wrong { Err(Error::Device("it left pixels that hold no radiance".into())) } else { Ok(()) }
}
