//! Pictures from PNG and JPEG files of strangers.
//!
//! The size that the file claims is held against the limits before anything is decoded. A JPEG whose end is missing is
//! refused, since decoders fill what is missing with grey. Orientation marks (EXIF) and colour profiles are ignored: pixels
//! are taken as they are stored, as sRGB.

use super::{Asset, allow_bytes, shown, unreadable};
use crate::base::diagnostic::{Diagnostic, Fault};
use crate::base::limits::{Limit, Limits};
use crate::base::picture::Picture;
use ::image::{ImageError, ImageFormat, ImageReader};
use std::fs::File;
use std::io::{Cursor, Read};

/// Bytes that decoding may take for each pixel: 16 bits in each of four channels, twice.
const DECODED_BYTES: u64 = 16;

/// Reads a picture that the scene names.
///
/// # Errors
/// [`Fault::Asset`] when it is unreadable, damaged or of another format, [`Fault::Limit`] when it has too many pixels; both at
/// the place where the scene names it.
pub fn read_picture(asset: &Asset, limits: &Limits) -> Result<Picture, Diagnostic> {
    bytes(asset, limits)
        .and_then(|bytes| decode(&asset.name, &bytes, limits))
        .map_err(|fault| fault.at(asset.place.clone()))
}

fn bytes(asset: &Asset, limits: &Limits) -> Result<Vec<u8>, Diagnostic> {
    let failed = |error: std::io::Error| unreadable(&asset.name, &error);
    let found = std::fs::metadata(&asset.path).map_err(failed)?;
    if !found.is_file() {
        // opening a pipe waits for its writer, and a device may never end
        let what = format!("\"{}\" is a folder, pipe or device", shown(&asset.name, super::QUOTED));
        return Err(Diagnostic::error(Fault::Asset, what, "name a PNG or JPEG file"));
    }
    let length = found.len();
    allow_bytes(&asset.name, length, limits)?;
    let file = File::open(&asset.path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

fn decode(name: &str, bytes: &[u8], limits: &Limits) -> Result<Picture, Diagnostic> {
    let name = shown(name, super::QUOTED);
    let damaged = |why: String| {
        Diagnostic::error(Fault::Asset, format!("\"{name}\" {why}"), "save the picture anew as PNG or JPEG")
    };
    let failed = |error: ImageError| damaged(format!("is damaged: {}", shown(error.to_string().trim(), 200)));
    let format = match ::image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
        _ if bytes.is_empty() => return Err(damaged("is empty".to_owned())),
        _ => return Err(damaged("is neither PNG nor JPEG".to_owned())),
    };
    if format == ImageFormat::Jpeg && !jpeg_ends(bytes) {
        return Err(damaged("is cut off: its end is missing".to_owned()));
    }
    let (width, height) = reader(bytes, format, u64::MAX).into_dimensions().map_err(failed)?;
    let pixels = u64::from(width) * u64::from(height);
    let what = format!("\"{name}\" ({width} x {height})");
    let allowed = limits.allow(Limit::PicturePixels, &what, pixels as f64);
    let allowed = allowed.and_then(|()| limits.allow(Limit::Memory, &what, pixels as f64 * DECODED_BYTES as f64));
    allowed.map_err(|refusal| Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help()))?;
    let most = pixels.saturating_mul(DECODED_BYTES) + 1_000_000;
    let decoded = reader(bytes, format, most).decode().map_err(failed)?.into_rgba8();
    let pixels = decoded.as_raw().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    Ok(Picture { width, height, pixels })
}

fn reader(bytes: &[u8], format: ImageFormat, most: u64) -> ImageReader<Cursor<&[u8]>> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = ::image::Limits::no_limits();
    limits.max_alloc = Some(most);
    reader.limits(limits);
    reader
}

/// Whether a JPEG has its end marker, FF D9, after the last scan. Segments are stepped over by their lengths (ITU T.81,
/// annex B), since a preview inside one has an end of its own.
fn jpeg_ends(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(marker) = next_marker(bytes, &mut at) {
        match marker {
            0xd9 => return true,
            // markers without a segment: stuffed byte, temporary, restarts, start
            0x00 | 0x01 | 0xd0..=0xd8 => {}
            _ => match bytes.get(at..at + 2) {
                Some(length) => at += usize::from(u16::from_be_bytes([length[0], length[1]])),
                None => return false,
            },
        }
    }
    false
}

/// The next marker at or after `at`, which is moved behind it. Any number of FF bytes may come before its code.
fn next_marker(bytes: &[u8], at: &mut usize) -> Option<u8> {
    let start = *at + bytes.get(*at..)?.iter().position(|byte| *byte == 0xff)?;
    let code = start + bytes[start..].iter().position(|byte| *byte != 0xff)?;
    *at = code + 1;
    Some(bytes[code])
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::codecs::jpeg::JpegEncoder;
    use ::image::{ExtendedColorType, ImageEncoder};

    fn png(width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder = ::image::codecs::png::PngEncoder::new(&mut bytes);
        encoder.write_image(pixels, width, height, ExtendedColorType::Rgba8).unwrap();
        bytes
    }

    fn jpeg() -> Vec<u8> {
        let mut bytes = Vec::new();
        JpegEncoder::new(&mut bytes).write_image(&[90; 16 * 16 * 3], 16, 16, ExtendedColorType::Rgb8).unwrap();
        bytes
    }

    #[test]
    fn pixels_come_back_as_they_were_written() {
        let raw: Vec<u8> = (0..2 * 3 * 4).collect();
        let picture = decode("a", &png(2, 3, &raw), &Limits::default()).unwrap();
        assert_eq!((picture.width, picture.height), (2, 3));
        assert_eq!(picture.pixels.concat(), raw);
    }

    #[test]
    fn every_cut_of_a_picture_is_refused() {
        for whole in [jpeg(), png(2, 3, &[7; 24])] {
            assert!(decode("a", &whole, &Limits::default()).is_ok());
            // the PNG's last chunk has no content; a picture without it is whole
            for length in 0..whole.len() - 12 {
                let fault = decode("a", &whole[..length], &Limits::default()).unwrap_err();
                assert_eq!(fault.fault, Fault::Asset, "{length}");
            }
        }
    }

    #[test]
    fn the_end_of_a_preview_is_not_the_end_of_the_picture() {
        let whole = jpeg();
        let preview = [&[0xff, 0xd8, 0xff, 0xe1, 0, 6], &[0xff, 0xd9, 0, 0][..], &whole[2..]].concat();
        assert!(jpeg_ends(&preview));
        assert!(!jpeg_ends(&preview[..preview.len() - 2]));
    }

    #[test]
    fn too_many_pixels_are_refused_with_the_flag() {
        let mut limits = Limits::default();
        limits.set(Limit::PicturePixels, 5.0);
        let file = png(2, 3, &[7; 24]);
        let fault = decode("a", &file, &limits).unwrap_err();
        assert_eq!(fault.fault, Fault::Limit);
        assert!(fault.help.contains("--limit picture-pixels=6"));
    }
}
