//! The end of a frame's work: its picture encoded, its files written, the manifest last. None of it needs what draws frames,
//! so one frame can be finished while the next is drawn.

use super::fault;
use super::files;
use super::manifest::{Key, Manifest};
use super::names::Names;
use crate::base::diagnostic::Diagnostics;
use crate::base::figures::Figures;
use crate::base::picture::Picture;
use crate::export::{self, ExportError};
use std::path::Path;
use std::time::Instant;

/// The files of a frame, by name.
pub type FrameFiles = Vec<(String, Vec<u8>)>;

/// A picture as its file will have it.
pub enum Image {
    /// 8 bits a channel.
    Eight(Picture),
    /// 16 bits a channel, row by row.
    Sixteen {
        /// Pixels in a row, and rows.
        size: [u32; 2],
        /// Red, green, blue and alpha.
        pixels: Vec<[u16; 4]>,
    },
}

impl Image {
    fn encoded(&self) -> Result<Vec<u8>, ExportError> {
        match self {
            Self::Eight(picture) => export::png(picture),
            Self::Sixteen { size: [width, height], pixels } => export::png_16(*width, *height, pixels),
        }
    }
}

/// What was made of a frame.
#[derive(Default)]
pub struct Made {
    /// Its picture, not yet encoded, with the name of its file.
    pub picture: Option<(String, Image)>,
    /// All other files.
    pub files: FrameFiles,
}

/// A frame's files as they were written.
pub struct Written {
    /// All of them, the picture first.
    pub files: FrameFiles,
    /// Wall time of encoding the picture, seconds, and its figures.
    pub encoding: Option<(f64, Figures)>,
    /// Wall time of all of it, seconds.
    pub seconds: f64,
}

impl Made {
    /// Encodes the picture and writes all files into a folder.
    ///
    /// # Errors
    /// When the picture cannot be encoded or a file cannot be written; then the frame has no manifest and does not count.
    pub fn written(self, folder: &Path, names: &Names, key: Key) -> Result<Written, Diagnostics> {
        let start = Instant::now();
        let mut files = self.files;
        let mut encoding = None;
        if let Some((name, picture)) = self.picture {
            let bytes = picture.encoded().map_err(|error| fault::export(&error))?;
            encoding = Some((start.elapsed().as_secs_f64(), Figures::of(1).with("bytes", bytes.len())));
            files.insert(0, (name, bytes));
        }
        for (name, bytes) in &files {
            files::write(&folder.join(name), bytes).map_err(|error| fault::written(&error))?;
        }
        let listed: Vec<(String, &[u8])> = files.iter().map(|(name, bytes)| (name.clone(), bytes.as_slice())).collect();
        let manifest = Manifest::new(&names.scene, names.frames, key, &listed);
        manifest.write(folder).map_err(|error| fault::written(&error))?;
        Ok(Written { files, encoding, seconds: start.elapsed().as_secs_f64() })
    }
}
