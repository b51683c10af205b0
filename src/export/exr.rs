//! Linear light as OpenEXR, where the program was built with it (feature `exr`).

use super::ExportError;
use super::png::check_size;

/// Encodes pixels as red, green, blue and alpha of 32-bit floating point numbers, rows from the top: linear sRGB primaries, not
/// clipped. Colours are multiplied by their alpha, as the format has it.
///
/// # Errors
/// When the number of pixels does not fit, when the encoder fails, and always without the feature `exr`.
pub fn exr(width: u32, height: u32, pixels: &[[f32; 4]]) -> Result<Vec<u8>, ExportError> {
    check_size("picture", width, height, pixels.len())?;
    let associated: Vec<[f32; 4]> = pixels.iter().map(|&[r, g, b, a]| [r * a, g * a, b * a, a]).collect();
    encode(width, height, &associated)
}

#[cfg(feature = "exr")]
fn encode(width: u32, height: u32, pixels: &[[f32; 4]]) -> Result<Vec<u8>, ExportError> {
    use image::codecs::openexr::OpenExrEncoder;
    use image::{ExtendedColorType, ImageEncoder};
    let bytes: Vec<u8> = pixels.as_flattened().iter().flat_map(|value| value.to_ne_bytes()).collect();
    let mut file = std::io::Cursor::new(Vec::new());
    let encoder = OpenExrEncoder::new(&mut file);
    encoder
        .write_image(&bytes, width, height, ExtendedColorType::Rgba32F)
        .map_err(|error| ExportError::Exr(error.to_string()))?;
    Ok(file.into_inner())
}

#[cfg(not(feature = "exr"))]
fn encode(_: u32, _: u32, _: &[[f32; 4]]) -> Result<Vec<u8>, ExportError> {
    Err(ExportError::Exr("this program was built without the feature `exr`".to_owned()))
}

#[cfg(all(test, feature = "exr"))]
mod tests {
    use super::*;

    #[test]
    fn another_reader_finds_the_same_light() {
        let pixels: Vec<[f32; 4]> =
            (0..12u8).map(|i| [f32::from(i) * 0.75, 0.1, 1e-4, if i == 3 { 0.5 } else { 1.0 }]).collect();
        let file = exr(4, 3, &pixels).unwrap();
        let read = image::load_from_memory_with_format(&file, image::ImageFormat::OpenExr).unwrap().into_rgba32f();
        for (read, pixel) in read.pixels().zip(&pixels) {
            let expected = [pixel[0] * pixel[3], pixel[1] * pixel[3], pixel[2] * pixel[3], pixel[3]];
            assert_eq!(read.0, expected);
        }
    }
}
