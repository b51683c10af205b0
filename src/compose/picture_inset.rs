//! Places a small picture in the lower right corner of a large one, as in Figure 12 of the paper.

use crate::base::picture::Picture;

/// Colour of the line around it.
const FRAME: [u8; 4] = [245, 245, 240, 255];

/// Draws `inset` with a thin frame into the lower right corner.
pub fn place(picture: &mut Picture, inset: &Picture) {
    let margin = picture.height / 50;
    let line = (picture.height / 360).max(1);
    let left = picture.width.saturating_sub(inset.width + margin + line);
    let top = picture.height.saturating_sub(inset.height + margin + line);
    for y in top.saturating_sub(line)..(top + inset.height + line).min(picture.height) {
        for x in left.saturating_sub(line)..(left + inset.width + line).min(picture.width) {
            let inside = x >= left && y >= top && x < left + inset.width && y < top + inset.height;
            let colour = if inside { inset.at(x - left, y - top) } else { FRAME };
            picture.pixels[y as usize * picture.width as usize + x as usize] = colour;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inset_lies_in_the_lower_right_corner() {
        let mut picture = Picture::filled(100, 100, [0, 0, 0, 255]);
        place(&mut picture, &Picture::filled(20, 20, [9, 9, 9, 255]));
        let count = picture.pixels.iter().filter(|&&p| p == [9, 9, 9, 255]).count();
        assert_eq!(count, 400);
        assert_eq!(picture.at(96, 96), [9, 9, 9, 255]);
        assert_eq!(picture.at(97, 97), FRAME);
        assert_eq!(picture.at(10, 10), [0, 0, 0, 255]);
    }
}
