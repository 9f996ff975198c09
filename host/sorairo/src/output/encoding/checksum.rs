//! The checksum of an EXR: the CRC-32 of the whole file with the checksum's own four bytes as zeros, in an attribute of
//! the header. The format itself has nothing that tells damage. PNG has a CRC-32 in every chunk.

use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
#[cfg(feature = "files")]
use std::io::{BufRead, BufReader};

use crc32fast::Hasher;
use exr::block::chunk::{Chunk, CompressedBlock};

/// The name of the attribute.
pub(crate) const CHECKSUM: &str = "sorairoChecksum";

/// The checksum of the blocks of lines of a file, which stand at its end.
#[derive(Default)]
pub(super) struct LinesChecksum {
    hasher: Hasher,
    bytes: u64,
}

impl LinesChecksum {
    /// That of one block: the number of its first line, its length, its bytes.
    pub(super) fn of(chunk: &Chunk) -> io::Result<Self> {
        let CompressedBlock::ScanLine(line) = &chunk.compressed_block else {
            return Err(io::Error::other("the image is not stored in lines"));
        };
        let data = &line.compressed_pixels_le;
        let length = i32::try_from(data.len()).map_err(io::Error::other)?;
        let mut hasher = Hasher::new();
        hasher.update(&line.y_coordinate.to_le_bytes());
        hasher.update(&length.to_le_bytes());
        hasher.update(data);
        Ok(Self { hasher, bytes: 8 + data.len() as u64 })
    }

    /// Appends the lines that follow.
    pub(super) fn append(&mut self, next: &Self) {
        self.hasher.combine(&next.hasher);
        self.bytes += next.bytes;
    }
}

/// Puts the checksum into its attribute, once the lines are written.
pub(super) fn write<W: Read + Write + Seek>(output: &mut BufWriter<W>, lines: &LinesChecksum) -> io::Result<()> {
    let length = output.seek(SeekFrom::End(0))?;
    output.rewind()?;
    let mut header = Vec::new();
    Read::take(output.get_mut(), length - lines.bytes).read_to_end(&mut header)?;
    let place = place(&header).ok_or_else(|| io::Error::other("the header has no checksum"))?;
    let mut hasher = Hasher::new();
    hasher.update(&header);
    hasher.combine(&lines.hasher);
    output.seek(SeekFrom::Start(place as u64))?;
    output.write_all(&hasher.finalize().to_le_bytes())
}

/// Whether a file has the checksum that it names.
#[cfg(feature = "files")]
pub(crate) fn is_right(file: impl Read) -> io::Result<bool> {
    // Longer than what stands before the attribute: 512 channels, and a scene with the names of three files.
    const START: usize = 1 << 17;
    let mut file = BufReader::with_capacity(START, file);
    let mut start = Vec::new();
    file.by_ref().take(START as u64).read_to_end(&mut start)?;
    let Some(place) = place(&start) else { return Ok(false) };
    let named = <[u8; 4]>::try_from(&start[place..place + 4]).expect("four bytes");
    start[place..place + 4].fill(0);
    let mut hasher = Hasher::new();
    hasher.update(&start);
    update(&mut hasher, &mut file)?;
    Ok(hasher.finalize() == u32::from_le_bytes(named))
}

/// Adds all that is left of a file to a checksum, and gives its length.
#[cfg(feature = "files")]
pub(crate) fn update(hasher: &mut Hasher, file: &mut impl BufRead) -> io::Result<u64> {
    let mut total = 0;
    loop {
        let bytes = file.fill_buf()?;
        if bytes.is_empty() {
            return Ok(total);
        }
        hasher.update(bytes);
        let length = bytes.len();
        file.consume(length);
        total += length as u64;
    }
}

/// Where the checksum stands in a header, or in more of a file than that.
fn place(header: &[u8]) -> Option<usize> {
    let attribute = [CHECKSUM.as_bytes(), b"\0int\0\x04\0\0\0"].concat();
    let at = header.windows(attribute.len()).position(|bytes| bytes == attribute)? + attribute.len();
    (at + 4 <= header.len()).then_some(at)
}
