//! Pictures that are drawn larger than they are wanted and averaged in linear light: more samples in a pixel than one pattern
//! has, with meshes, textures and shading as fine.

use crate::base::encoding::linear_values;
use crate::base::maths::linear_to_srgb8;
use crate::base::picture::Picture;
use crate::frame::Frame;
use crate::raster::{Drawing, Renderer, Wanted};
use rayon::prelude::*;

/// Draws a frame `times` as large in each direction and averages it to its own size; what the rasteriser tells is of the
/// large picture, its antialiasing error scaled to the samples that a pixel has. What is seen in each pixel cannot be averaged:
/// that, and the shadow on the ground, are those of a frame of its own size.
#[must_use]
pub fn drawn(renderer: &mut Renderer, frame: &Frame, times: u32, wanted: Wanted) -> Drawing {
    if times <= 1 {
        return renderer.draw_wanted(frame, wanted);
    }
    let (sites, ground_shadow) = if !wanted.sites && !wanted.ground_shadow {
        (Vec::new(), Vec::new())
    } else {
        let drawing = renderer.draw_apart(frame, Wanted { radiance: false, ..wanted });
        (drawing.sites, drawing.ground_shadow)
    };
    let mut large = frame.clone();
    large.view.width *= times;
    large.view.height *= times;
    if let Some(lines) = &mut large.view.wireframe {
        lines.width *= times as f32;
    }
    let drawing = renderer
        .draw_wanted(&large, Wanted { radiance: wanted.radiance, is_last: wanted.is_last, ..Wanted::default() });
    let mut figures = drawing.figures;
    if let Some(error) = &mut figures.error {
        error.value /= f64::from(times);
        error.how = format!("{}, averaged over {times} x {times} pixels", error.how);
    }
    let radiance = averaged_light(&drawing.radiance, large.view.width as usize, times as usize);
    let figures = figures.with("enlarged", times);
    Drawing { picture: averaged(&drawing.picture, times), sites, radiance, ground_shadow, figures }
}

/// Each `times` x `times` pixels of light averaged, colours by their alpha; rows are of `width` pixels.
fn averaged_light(large: &[[f32; 4]], width: usize, times: usize) -> Vec<[f32; 4]> {
    let strip = |rows: &[[f32; 4]]| {
        let mean = |x: usize| {
            let pixels = || rows.chunks(width).flat_map(move |row| &row[x * times..][..times]);
            let alpha: f32 = pixels().map(|pixel| pixel[3]).sum();
            let channel = |k: usize| pixels().map(|pixel| pixel[k] * pixel[3]).sum::<f32>() / alpha.max(1e-9);
            [channel(0), channel(1), channel(2), alpha / (times * times) as f32]
        };
        (0..width / times).map(mean).collect::<Vec<_>>()
    };
    large.par_chunks(width * times).flat_map_iter(strip).collect()
}

/// Each `times` x `times` pixels averaged in linear light, colours by their alpha.
#[must_use]
pub fn averaged(large: &Picture, times: u32) -> Picture {
    let table = linear_values();
    let (width, height) = (large.width / times, large.height / times);
    let mut picture = Picture::filled(width, height, [0, 0, 0, 255]);
    picture.pixels.par_chunks_mut(width.max(1) as usize).enumerate().for_each(|(y, line)| {
        for (x, pixel) in line.iter_mut().enumerate() {
            let rows = (0..times as usize).map(|row| (y * times as usize + row) * large.width as usize);
            let sources = rows.flat_map(|row| &large.pixels[row + x * times as usize..][..times as usize]);
            *pixel = mean(sources, &table);
        }
    });
    picture
}

/// The mean of some pixels.
fn mean<'a>(pixels: impl Iterator<Item = &'a [u8; 4]>, table: &[f32; 256]) -> [u8; 4] {
    let (mut sum, mut alpha, mut count) = ([0.0f32; 3], 0.0f32, 0.0f32);
    for pixel in pixels {
        let own = f32::from(pixel[3]) / 255.0;
        (0..3).for_each(|k| sum[k] += table[usize::from(pixel[k])] * own);
        alpha += own;
        count += 1.0;
    }
    let [red, green, blue] = sum.map(|sum| if alpha > 0.0 { linear_to_srgb8(sum / alpha) } else { 0 });
    [red, green, blue, (alpha / count * 255.0 + 0.5) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::srgb_to_linear;

    #[test]
    fn averages_are_taken_in_linear_light() {
        let mut large = Picture::filled(4, 2, [0, 0, 0, 255]);
        for at in [0, 5] {
            large.pixels[at] = [255, 255, 255, 255];
        }
        large.pixels[2] = [188, 188, 188, 255];
        let small = averaged(&large, 2);
        assert_eq!((small.width, small.height), (2, 1));
        // Half of the light is code 188; an eighth of it code 99.
        assert_eq!(small.pixels[0], [188, 188, 188, 255]);
        large.pixels.iter_mut().step_by(2).for_each(|pixel| pixel[3] = 0);
        assert_eq!(averaged(&large, 2).pixels[1], [0, 0, 0, 128]);
        assert_eq!(small.pixels[1][0], linear_to_srgb8(srgb_to_linear(188.0 / 255.0) / 4.0));
    }
}
