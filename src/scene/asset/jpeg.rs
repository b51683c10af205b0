//! What a JPEG's markers tell before it is decoded. Segments are stepped over by their lengths (ITU T.81, annex B), since a
//! preview inside one has markers of its own.

/// What the markers tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Markers {
    /// Whether the end marker, FF D9, stands after the last scan. Decoders fill what is missing with grey.
    pub ends: bool,
    /// Colour components of the frame; 0 without one.
    pub components: u8,
}

/// Steps through the markers of a JPEG.
pub fn markers(bytes: &[u8]) -> Markers {
    let mut found = Markers::default();
    let mut at = 2;
    while let Some(marker) = next_marker(bytes, &mut at) {
        match marker {
            0xd9 => return Markers { ends: true, ..found },
            // markers without a segment: stuffed byte, temporary, restarts, start
            0x00 | 0x01 | 0xd0..=0xd8 => continue,
            // frame headers: length, precision, height, width, number of components
            0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => {
                found.components = bytes.get(at + 7).copied().unwrap_or(0);
            }
            _ => {}
        }
        match bytes.get(at..at + 2) {
            Some(length) => at += usize::from(u16::from_be_bytes([length[0], length[1]])),
            None => break,
        }
    }
    found
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
    use ::image::ExtendedColorType;
    use ::image::codecs::jpeg::JpegEncoder;

    fn jpeg(colour: ExtendedColorType, channels: usize) -> Vec<u8> {
        let mut bytes = Vec::new();
        JpegEncoder::new(&mut bytes).encode(&vec![90; 16 * 16 * channels], 16, 16, colour).unwrap();
        bytes
    }

    #[test]
    fn components_and_end_are_found() {
        assert_eq!(markers(&jpeg(ExtendedColorType::Rgb8, 3)), Markers { ends: true, components: 3 });
        let grey = jpeg(ExtendedColorType::L8, 1);
        assert_eq!(markers(&grey), Markers { ends: true, components: 1 });
        assert_eq!(markers(&grey[..grey.len() - 1]), Markers { ends: false, components: 1 });
        assert_eq!(markers(&[0xff, 0xd8]), Markers::default());
    }

    #[test]
    fn the_end_of_a_preview_is_not_the_end_of_the_picture() {
        let whole = jpeg(ExtendedColorType::Rgb8, 3);
        let preview = [&[0xff, 0xd8, 0xff, 0xe1, 0, 6], &[0xff, 0xd9, 0, 0][..], &whole[2..]].concat();
        assert!(markers(&preview).ends);
        assert!(!markers(&preview[..preview.len() - 2]).ends);
    }
}
