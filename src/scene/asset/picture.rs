//! Pictures from PNG and JPEG files of strangers.
//!
//! The size that the file claims is held against the limits before anything is decoded. A JPEG whose end is missing is
//! refused, since decoders fill what is missing with grey, and so is one in printers' inks (CMYK). A picture is turned as its
//! orientation mark (EXIF) says; colour profiles are ignored: colours are taken as sRGB. 16 bits a channel are rounded to 8;
//! of an animation the first frame, or the one that stands for it, is taken.

use super::{Asset, allow_bytes, jpeg, shown, unreadable};
use crate::base::diagnostic::{Diagnostic, Fault};
use crate::base::limits::{Limit, Limits};
use crate::base::picture::Picture;
use ::image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};
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
        Diagnostic::error(Fault::Asset, format!("\"{name}\" {why}"), "save the picture anew as PNG, or as JPEG in RGB")
    };
    let failed = |error: ImageError| damaged(format!("is damaged: {}", shown(error.to_string().trim(), 200)));
    let format = match ::image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
        _ if bytes.is_empty() => return Err(damaged("is empty".to_owned())),
        _ => return Err(damaged("is neither PNG nor JPEG".to_owned())),
    };
    if format == ImageFormat::Jpeg {
        let markers = jpeg::markers(bytes);
        if !markers.ends {
            return Err(damaged("is cut off: its end is missing".to_owned()));
        }
        if markers.components == 4 {
            return Err(damaged("is in printers' inks (CMYK)".to_owned()));
        }
    }
    let (width, height) = reader(bytes, format, u64::MAX).into_dimensions().map_err(failed)?;
    let pixels = u64::from(width) * u64::from(height);
    let what = format!("\"{name}\" ({width} x {height})");
    let allowed = limits.allow(Limit::PicturePixels, &what, pixels as f64);
    let allowed = allowed.and_then(|()| limits.allow(Limit::Memory, &what, pixels as f64 * DECODED_BYTES as f64));
    allowed.map_err(|refusal| Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help()))?;
    let most = pixels.saturating_mul(DECODED_BYTES) + 1_000_000;
    let decoded = upright(reader(bytes, format, most)).map_err(failed)?.into_rgba8();
    let pixels = decoded.as_raw().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    Ok(Picture { width: decoded.width(), height: decoded.height(), pixels })
}

/// The picture turned and mirrored as its orientation mark says, at 8 bits a channel.
fn upright(reader: ImageReader<Cursor<&[u8]>>) -> Result<DynamicImage, ImageError> {
    let mut decoder = reader.into_decoder()?;
    let orientation = decoder.orientation()?;
    let mut picture = DynamicImage::ImageRgba8(DynamicImage::from_decoder(decoder)?.into_rgba8());
    picture.apply_orientation(orientation);
    Ok(picture)
}

fn reader(bytes: &[u8], format: ImageFormat, most: u64) -> ImageReader<Cursor<&[u8]>> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = ::image::Limits::no_limits();
    limits.max_alloc = Some(most);
    reader.limits(limits);
    reader
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
    fn too_many_pixels_are_refused_with_the_flag() {
        let mut limits = Limits::default();
        limits.set(Limit::PicturePixels, 5.0);
        let file = png(2, 3, &[7; 24]);
        let fault = decode("a", &file, &limits).unwrap_err();
        assert_eq!(fault.fault, Fault::Limit);
        assert!(fault.help.contains("--limit picture-pixels=6"));
    }
    /// An EXIF block (TIFF, little-endian) of one entry: orientation, tag 0x0112, a short.
    fn exif(orientation: u8) -> Vec<u8> {
        let head = [b'I', b'I', 42, 0, 8, 0, 0, 0, 1, 0];
        [&head[..], &[0x12, 0x01, 3, 0, 1, 0, 0, 0, orientation, 0, 0, 0], &[0; 4]].concat()
    }

    /// A picture of 2 x 3 pixels with its red, green, blue and white quarters' corners told apart by brightness alone.
    const CORNERS: [u8; 6] = [10, 60, 120, 140, 200, 250];

    /// Where the stored pixel of each shown one lies, from the table of the EXIF standard (2.3, tag Orientation): the sides
    /// at which row 0 and column 0 of the stored picture are shown.
    fn shown_by(orientation: u8) -> (u32, u32, Vec<u8>) {
        let stored = |x: usize, y: usize| CORNERS[y * 2 + x];
        let turned = orientation >= 5;
        let (width, height) = if turned { (3, 2) } else { (2, 3) };
        let pixel = |x: usize, y: usize| match orientation {
            2 => stored(1 - x, y),
            3 => stored(1 - x, 2 - y),
            4 => stored(x, 2 - y),
            5 => stored(y, x),
            6 => stored(y, 2 - x),
            7 => stored(1 - y, 2 - x),
            8 => stored(1 - y, x),
            _ => stored(x, y),
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        (width as u32, height as u32, pixels)
    }

    #[test]
    fn a_png_is_turned_as_its_mark_says() {
        for orientation in 1..=8 {
            let mut bytes = Vec::new();
            let mut encoder = ::image::codecs::png::PngEncoder::new(&mut bytes);
            encoder.set_exif_metadata(exif(orientation)).unwrap();
            encoder.write_image(&CORNERS, 2, 3, ExtendedColorType::L8).unwrap();
            let picture = decode("a", &bytes, &Limits::default()).unwrap();
            let red: Vec<u8> = picture.pixels.iter().map(|p| p[0]).collect();
            assert_eq!((picture.width, picture.height, red), shown_by(orientation), "orientation {orientation}");
        }
    }

    #[test]
    fn a_jpeg_is_turned_as_its_mark_says() {
        // each pixel of the small picture is a block of 16, well inside which JPEG keeps the value
        let raw: Vec<u8> = (0..32 * 48).map(|i| CORNERS[i / 32 / 16 * 2 + i % 32 / 16]).collect();
        for orientation in 1..=8 {
            let mut bytes = Vec::new();
            let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 100);
            encoder.set_exif_metadata(exif(orientation)).unwrap();
            encoder.write_image(&raw, 32, 48, ExtendedColorType::L8).unwrap();
            let picture = decode("a", &bytes, &Limits::default()).unwrap();
            let (width, height, wanted) = shown_by(orientation);
            assert_eq!((picture.width, picture.height), (width * 16, height * 16));
            for (i, value) in wanted.into_iter().enumerate() {
                let (x, y) = (i as u32 % width * 16 + 8, i as u32 / width * 16 + 8);
                assert!(picture.at(x, y)[0].abs_diff(value) <= 2, "orientation {orientation}, pixel {i}");
            }
        }
    }

    #[test]
    fn every_kind_of_png_gives_its_colours() {
        use ::png::{BitDepth, ColorType};
        let write = |colour: ColorType, depth: BitDepth, palette: Option<Vec<u8>>, data: &[u8]| {
            let mut bytes = Vec::new();
            let mut encoder = ::png::Encoder::new(&mut bytes, 2, 1);
            encoder.set_color(colour);
            encoder.set_depth(depth);
            if let Some(palette) = palette {
                encoder.set_palette(palette);
                encoder.set_trns(vec![255, 7]);
            }
            encoder.write_header().unwrap().write_image_data(data).unwrap();
            decode("a", &bytes, &Limits::default()).unwrap().pixels
        };
        let grey = |v: u8, a: u8| [v, v, v, a];
        let bits = write(ColorType::Grayscale, BitDepth::One, None, &[0b0100_0000]);
        assert_eq!(bits, [grey(0, 255), grey(255, 255)]);
        let eight = write(ColorType::GrayscaleAlpha, BitDepth::Eight, None, &[9, 40, 200, 255]);
        assert_eq!(eight, [grey(9, 40), grey(200, 255)]);
        // 257 to a code of 8 bits; 0x80ff lies nearest 0x81
        let sixteen = write(ColorType::Grayscale, BitDepth::Sixteen, None, &[0x40, 0x40, 0x80, 0xff]);
        assert_eq!(sixteen, [grey(0x40, 255), grey(0x80, 255)]);
        let wide: Vec<u8> = [0x1111u16, 0x2222, 0x3333, 0xffff, 0, 0x8080, 0xffff, 0x7f7f]
            .iter()
            .flat_map(|v| v.to_be_bytes())
            .collect();
        assert_eq!(
            write(ColorType::Rgba, BitDepth::Sixteen, None, &wide),
            [[0x11, 0x22, 0x33, 255], [0, 0x80, 255, 0x7f]]
        );
        let palette = Some(vec![1, 2, 3, 4, 5, 6]);
        assert_eq!(write(ColorType::Indexed, BitDepth::Two, palette, &[0b0100_0000]), [[4, 5, 6, 7], [1, 2, 3, 255]]);
    }

    #[test]
    fn inks_are_refused() {
        let mut whole = jpeg();
        let frame = whole.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        whole[frame + 9] = 4;
        let fault = decode("a", &whole, &Limits::default()).unwrap_err();
        assert!(fault.message.contains("CMYK") && fault.help.contains("RGB"), "{fault:?}");
    }

    #[derive(serde::Deserialize)]
    struct Case {
        file: String,
        expect: String,
        class: String,
    }

    #[test]
    fn shared_bad_pictures_are_refused_by_name() {
        let here = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let folders = ["../shared/badinput", "../../shared/badinput"].map(|folder| here.join(folder));
        let folder = folders.iter().find(|folder| folder.is_dir()).unwrap_or(&folders[0]);
        let Ok(text) = std::fs::read_to_string(folder.join("images.json")) else { return };
        for case in serde_json::from_str::<Vec<Case>>(&text).unwrap() {
            let asset = Asset::outside(&folder.join("images").join(&case.file));
            match read_picture(&asset, &Limits::default()) {
                Ok(_) => assert_eq!(case.expect, "accept", "{}", case.file),
                Err(fault) => {
                    assert_eq!(case.expect, "reject", "{}", case.file);
                    let class = if fault.fault == Fault::Limit { "limit" } else { "asset" };
                    assert_eq!(class, case.class, "{}: {}", case.file, fault.message);
                    assert!(fault.message.contains(&case.file), "{}", fault.message);
                }
            }
        }
    }
}
