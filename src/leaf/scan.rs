//! The user's scan laid out by the mesh's texture coordinates, and greys out of a painted mask.

use crate::base::flat_mesh::FlatMesh;
use crate::base::picture::Picture;
use crate::base::vector::{DVec2, Vec2};
use crate::leaf::grid::Grid;
use crate::leaf::trace::Trace;
use rayon::prelude::*;

/// Pixels along a side of the laid-out scan: the power of two that comes nearest to the scan's own resolution, within these.
const SIDES: [usize; 2] = [256, 2048];
/// Most samples of a texel along each axis.
const TAPS: usize = 3;

/// The scan, square; where the leaf is not it is clear, in the colour of the leaf's nearest rim.
pub fn laid_out(picture: &Picture, trace: &Trace, mesh: &FlatMesh) -> Picture {
    let inner = eroded(&trace.blade);
    let pixels_across = 1.0 / (mesh.uv_scale * trace.pose.scale);
    let side = side(pixels_across);
    let taps = ((pixels_across / side as f64).ceil() as usize).clamp(1, TAPS);
    let texel = |i: usize| texel(picture, &inner, trace, mesh, (i, side, taps));
    filled((0..side * side).into_par_iter().map(texel).collect(), side, side)
}

/// A texture that was written by [`laid_out`], and maybe painted over: colours where it is clear do not count.
pub fn read_back(texture: &Picture) -> Picture {
    let cell = |p: &[u8; 4]| (p[3] > 127).then(|| [0, 1, 2].map(|k: usize| f32::from(p[k])));
    filled(texture.pixels.iter().map(cell).collect(), texture.width as usize, texture.height as usize)
}

/// The power of two nearest to a number of pixels by ratio.
fn side(pixels: f64) -> usize {
    let next = (pixels.clamp(1.0, 1e6) as usize).next_power_of_two();
    let side = if next as f64 > pixels * std::f64::consts::SQRT_2 { next / 2 } else { next };
    side.clamp(SIDES[0], SIDES[1])
}

/// A picture of known and unknown cells, the unknown ones clear and in the colour of what is nearest.
fn filled(mut cells: Vec<Option<[f32; 3]>>, width: usize, height: usize) -> Picture {
    // Known colours as the file will hold them, so that reading it back fills the rest in the same way.
    cells.iter_mut().flatten().for_each(|colour| *colour = colour.map(|x| (x + 0.5).floor()));
    let alphas: Vec<u8> = cells.iter().map(|cell| if cell.is_some() { 255 } else { 0 }).collect();
    dilate(&mut cells, width, height);
    let code = |(c, alpha): (Option<[f32; 3]>, u8)| {
        let [r, g, b] = c.unwrap_or([0.0; 3]).map(|x| (x + 0.5) as u8);
        [r, g, b, alpha]
    };
    Picture { width: width as u32, height: height as u32, pixels: cells.into_iter().zip(alphas).map(code).collect() }
}

/// The blade's colour without its outermost pixels, which blur and shadow mix with the background's.
fn eroded(shown: &Grid<bool>) -> Grid<bool> {
    let side = shown.width.max(shown.height) as f64;
    let rim = (0.0025 * side).max(2.5);
    shown.map(|c| !c).dilated(rim).map(|c| !c)
}

/// Mean of the leaf's colours under a texel; `None` when most of it is background.
fn texel(
    picture: &Picture,
    inner: &Grid<bool>,
    trace: &Trace,
    mesh: &FlatMesh,
    (number, side, taps): (usize, usize, usize),
) -> Option<[f32; 3]> {
    let (mut sum, mut count) = ([0.0f32; 3], 0usize);
    for tap in 0..taps * taps {
        let place = |cell: usize, tap: usize| (cell as f64 + (tap as f64 + 0.5) / taps as f64) / side as f64;
        let (u, v) = (place(number % side, tap % taps), place(number / side, tap / taps));
        let plane = DVec2::new(u - mesh.uv_origin.x, mesh.uv_origin.y - v) / mesh.uv_scale;
        let pixel = trace.pose.pixel(plane);
        let (x, y) = (pixel.x.floor(), pixel.y.floor());
        let fits = x >= 0.0 && y >= 0.0 && x < inner.width as f64 && y < inner.height as f64;
        if fits && inner.at(x as usize, y as usize) {
            let colour = bilinear(picture, pixel);
            sum = [0, 1, 2].map(|i| sum[i] + colour[i]);
            count += 1;
        }
    }
    (count * 2 > taps * taps).then(|| sum.map(|s| s / count as f32))
}

/// Encoded colour at a place in pixels (first pixel's centre at 0.5), the rim continued.
fn bilinear(picture: &Picture, place: DVec2) -> [f32; 3] {
    let clamp = |i: f64, size: u32| i.clamp(0.0, f64::from(size - 1));
    let (x, y) = (clamp(place.x - 0.5, picture.width), clamp(place.y - 0.5, picture.height));
    let (left, top) = (x.floor() as u32, y.floor() as u32);
    let (right, below) = ((left + 1).min(picture.width - 1), (top + 1).min(picture.height - 1));
    let (s, t) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let at = |x: u32, y: u32, i: usize| f32::from(picture.at(x, y)[i]);
    [0, 1, 2].map(|i| {
        let upper = at(left, top, i) * (1.0 - s) + at(right, top, i) * s;
        let lower = at(left, below, i) * (1.0 - s) + at(right, below, i) * s;
        upper * (1.0 - t) + lower * t
    })
}

/// Empty cells take the mean of their known neighbours, ring after ring.
fn dilate(cells: &mut [Option<[f32; 3]>], width: usize, height: usize) {
    let grid = Grid { width, height, cells: cells.iter().map(Option::is_some).collect() };
    let mut front: Vec<usize> = (0..cells.len()).filter(|&i| cells[i].is_none()).collect();
    front.retain(|&i| grid.neighbours(i).any(|n| cells[n].is_some()));
    while !front.is_empty() {
        let mean = |i: usize| {
            let known: Vec<[f32; 3]> = grid.neighbours(i).filter_map(|n| cells[n]).collect();
            [0, 1, 2].map(|c| known.iter().map(|k| k[c]).sum::<f32>() / known.len() as f32)
        };
        let colours: Vec<[f32; 3]> = front.iter().map(|&i| mean(i)).collect();
        for (&i, colour) in front.iter().zip(colours) {
            cells[i] = Some(colour);
        }
        let mut next: Vec<usize> =
            front.iter().flat_map(|&i| grid.neighbours(i)).filter(|&n| cells[n].is_none()).collect();
        next.sort_unstable();
        next.dedup();
        front = next;
    }
}

/// Grey (0 to 255) of a mask at texture coordinates: the mean of red, green and blue, bilinear.
pub fn grey_at(mask: &Picture, uv: Vec2) -> f64 {
    if mask.width == 0 || mask.height == 0 {
        return 255.0;
    }
    let place = DVec2::new(f64::from(uv.x) * f64::from(mask.width), f64::from(uv.y) * f64::from(mask.height));
    let [r, g, b] = bilinear(mask, place);
    f64::from(r + g + b) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_is_read_between_its_pixels() {
        let mut mask = Picture::filled(2, 1, [0, 0, 0, 255]);
        mask.pixels[1] = [200, 200, 200, 255];
        assert_eq!(grey_at(&mask, Vec2::new(0.25, 0.5)), 0.0);
        assert_eq!(grey_at(&mask, Vec2::new(0.5, 0.5)), 100.0);
        assert_eq!(grey_at(&mask, Vec2::new(0.9, 0.5)), 200.0);
    }

    #[test]
    fn the_side_is_the_power_of_two_that_comes_nearest() {
        let found: Vec<usize> = [10.0, 300.0, 700.0, 730.0, 1000.0, 9000.0].map(side).into();
        assert_eq!(found, [256, 256, 512, 1024, 1024, 2048]);
    }

    #[test]
    fn clear_parts_of_a_texture_take_the_colour_of_the_leaf() {
        let mut texture = Picture::filled(8, 8, [0, 0, 0, 0]);
        texture.pixels[27] = [50, 90, 30, 255];
        let read = read_back(&texture);
        assert!(read.pixels.iter().all(|p| p[..3] == [50, 90, 30]));
        assert_eq!(read.pixels.iter().filter(|p| p[3] == 255).count(), 1);
        assert_eq!(read_back(&read), read);
    }

    #[test]
    fn dilation_fills_everything_with_what_is_there() {
        let mut cells = vec![None; 60 * 40];
        cells[60 * 10 + 10] = Some([10.0, 20.0, 30.0]);
        dilate(&mut cells, 60, 40);
        assert!(cells.iter().all(|c| *c == Some([10.0, 20.0, 30.0])));
    }
}
