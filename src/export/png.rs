//! A picture as a PNG file: 8-bit sRGB, RGB when every pixel is opaque and RGBA otherwise.

use super::ExportError;
use crate::base::picture::Picture;
use ::png::{BitDepth, ColorType, Compression, Encoder, Filter, SrgbRenderingIntent};

/// Encodes a picture. The file has an sRGB chunk and neither text nor time.
///
/// # Errors
/// [`ExportError::Size`] when the pixels do not fill the picture, [`ExportError::Png`] from the encoder.
pub fn png(picture: &Picture) -> Result<Vec<u8>, ExportError> {
    let (width, height) = (picture.width, picture.height);
    check_size("picture", width, height, picture.pixels.len())?;
    if picture.pixels.iter().all(|pixel| pixel[3] == 255) {
        let opaque: Vec<[u8; 3]> = picture.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        return encode(width, height, ColorType::Rgb, opaque.as_flattened());
    }
    encode(width, height, ColorType::Rgba, picture.pixels.as_flattened())
}

/// Encodes 16 bits a channel, sRGB with straight alpha, rows from the top; opaque pixels without alpha.
///
/// # Errors
/// As [`png()`].
pub fn png_16(width: u32, height: u32, pixels: &[[u16; 4]]) -> Result<Vec<u8>, ExportError> {
    check_size("picture", width, height, pixels.len())?;
    let is_opaque = pixels.iter().all(|pixel| pixel[3] == u16::MAX);
    let (colour, channels) = if is_opaque { (ColorType::Rgb, 3) } else { (ColorType::Rgba, 4) };
    let bytes: Vec<u8> =
        pixels.iter().flat_map(|pixel| &pixel[..channels]).flat_map(|code| code.to_be_bytes()).collect();
    encode_as(width, height, (colour, BitDepth::Sixteen), true, &bytes)
}

/// Encodes numbers in three channels that are no colours: the file names no colour space.
///
/// # Errors
/// As [`png()`].
pub fn plain(width: u32, height: u32, pixels: &[[u8; 3]]) -> Result<Vec<u8>, ExportError> {
    check_size("layer", width, height, pixels.len())?;
    encode_as(width, height, (ColorType::Rgb, BitDepth::Eight), false, pixels.as_flattened())
}

/// Encodes numbers of 8 bits, see [`plain`].
///
/// # Errors
/// As [`png()`].
pub fn grey_8(width: u32, height: u32, pixels: &[u8]) -> Result<Vec<u8>, ExportError> {
    check_size("layer", width, height, pixels.len())?;
    encode_as(width, height, (ColorType::Grayscale, BitDepth::Eight), false, pixels)
}

/// Encodes numbers of 16 bits, see [`plain`].
///
/// # Errors
/// As [`png()`].
pub fn grey_16(width: u32, height: u32, pixels: &[u16]) -> Result<Vec<u8>, ExportError> {
    check_size("layer", width, height, pixels.len())?;
    let bytes: Vec<u8> = pixels.iter().flat_map(|value| value.to_be_bytes()).collect();
    encode_as(width, height, (ColorType::Grayscale, BitDepth::Sixteen), false, &bytes)
}

/// Encodes opaque pixels, rows from the top.
pub(super) fn opaque(width: u32, height: u32, pixels: &[[u8; 3]]) -> Result<Vec<u8>, ExportError> {
    encode(width, height, ColorType::Rgb, pixels.as_flattened())
}

/// Refuses an empty picture and one whose pixels do not fill it.
pub(super) fn check_size(what: &str, width: u32, height: u32, pixels: usize) -> Result<(), ExportError> {
    if pixels > 0 && pixels as u64 == u64::from(width) * u64::from(height) {
        return Ok(());
    }
    Err(ExportError::Size { what: what.to_owned(), width, height, pixels })
}

fn encode(width: u32, height: u32, colour: ColorType, bytes: &[u8]) -> Result<Vec<u8>, ExportError> {
    encode_as(width, height, (colour, BitDepth::Eight), true, bytes)
}

fn encode_as(
    width: u32,
    height: u32,
    (colour, depth): (ColorType, BitDepth),
    is_srgb: bool,
    bytes: &[u8],
) -> Result<Vec<u8>, ExportError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    // Measured on 1080p frames: Balanced takes 28 times as long for a file smaller by a tenth.
    encoder.set_compression(Compression::Fast);
    // Each pixel less the one before it: on frames of trees a sixtieth larger than by the best filter of each row, in six tenths
    // of the time.
    encoder.set_filter(Filter::Sub);
    if is_srgb {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageFormat, load_from_memory_with_format};

    fn gradient(alpha: u8) -> Picture {
        let pixels = (0..35u8).map(|i| [i * 7, 255 - i, i, if i == 3 { alpha } else { 255 }]).collect();
        Picture { width: 7, height: 5, pixels }
    }

    fn chunks(file: &[u8]) -> Vec<String> {
        let mut names = Vec::new();
        let mut at = 8;
        while at + 8 <= file.len() {
            let length = u32::from_be_bytes(file[at..at + 4].try_into().unwrap()) as usize;
            names.push(String::from_utf8_lossy(&file[at + 4..at + 8]).into_owned());
            at += 12 + length;
        }
        names
    }

    #[test]
    fn another_decoder_reads_the_same_16_bits() {
        for last in [u16::MAX, 700] {
            let pixels: Vec<[u16; 4]> =
                (0..12u16).map(|i| [i * 5000, 65535 - i, i, if i == 11 { last } else { u16::MAX }]).collect();
            let file = png_16(4, 3, &pixels).unwrap();
            let read = load_from_memory_with_format(&file, ImageFormat::Png).unwrap();
            assert_eq!(matches!(read, DynamicImage::ImageRgb16(_)), last == u16::MAX);
            assert!(read.into_rgba16().pixels().zip(&pixels).all(|(read, pixel)| read.0 == *pixel));
        }
    }

    #[test]
    fn another_decoder_reads_the_same_pixels() {
        for alpha in [255, 17] {
            let picture = gradient(alpha);
            let image = load_from_memory_with_format(&png(&picture).unwrap(), ImageFormat::Png).unwrap();
            assert_eq!(matches!(image, DynamicImage::ImageRgb8(_)), alpha == 255);
            assert_eq!((image.width(), image.height()), (7, 5));
            assert_eq!(image.to_rgba8().into_raw(), picture.pixels.as_flattened());
        }
    }

    #[test]
    fn the_colour_space_is_named_and_no_text_or_time_is_there() {
        let names = chunks(&png(&gradient(255)).unwrap());
        assert!(names.iter().any(|name| name == "sRGB"), "{names:?}");
        assert!(
            names.iter().all(|n| ["IHDR", "sRGB", "gAMA", "cHRM", "IDAT", "IEND"].contains(&n.as_str())),
            "{names:?}"
        );
    }

    #[test]
    fn numbers_are_read_back_as_they_are() {
        let deep: Vec<u16> = (0..35).map(|i| i * 1871).collect();
        let image = load_from_memory_with_format(&grey_16(7, 5, &deep).unwrap(), ImageFormat::Png).unwrap();
        assert_eq!(image.to_luma16().into_raw(), deep);
        let file = plain(7, 5, &[[1, 2, 3]; 35]).unwrap();
        assert!(chunks(&file).iter().all(|name| ["IHDR", "IDAT", "IEND"].contains(&name.as_str())));
        assert!(matches!(grey_8(7, 5, &[0; 34]), Err(ExportError::Size { pixels: 34, .. })));
    }

    #[test]
    fn pixels_that_do_not_fill_the_picture_are_refused() {
        let mut picture = gradient(255);
        picture.pixels.pop();
        assert!(matches!(png(&picture), Err(ExportError::Size { pixels: 34, .. })));
        assert!(matches!(png(&Picture::default()), Err(ExportError::Size { .. })));
    }
}
