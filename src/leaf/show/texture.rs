//! The user's scan laid out by the mesh's texture coordinates, and greys out of a painted mask.

use crate::base::flat_mesh::FlatMesh;
use crate::base::picture::Picture;
use crate::base::vector::{DVec2, Vec2};
use crate::leaf::grid::Grid;
use crate::leaf::raster::cell_of;
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
    let places = |origin: f64, sense: f64, axis: DVec2| -> Vec<DVec2> {
        let place = |i: usize| (i / taps) as f64 + ((i % taps) as f64 + 0.5) / taps as f64;
        let plane = |i: usize| sense * (place(i) / side as f64 - origin) / mesh.uv_scale;
        (0..side * taps).map(|i| axis * plane(i)).collect()
    };
    let pose = &trace.pose;
    let across = DVec2::new(-pose.axis.y, pose.axis.x);
    let columns = places(mesh.uv_origin.x, 1.0, across);
    let rows = places(mesh.uv_origin.y, -1.0, pose.axis);
    let texel = |i: usize| {
        let (x, y) = (i % side * taps, i / side * taps);
        let pixel = |from: DVec2, up: DVec2| pose.joint + (from + up) / pose.scale;
        let (columns, rows) = (&columns[x..x + taps], &rows[y..y + taps]);
        texel(picture, &inner, rows.iter().flat_map(|&up| columns.iter().map(move |&from| pixel(from, up))))
    };
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

/// Mean of the leaf's colours at the places (pixels) under a texel; `None` when most of them are background.
fn texel(picture: &Picture, inner: &Grid<bool>, places: impl Iterator<Item = DVec2>) -> Option<[f32; 3]> {
    let (mut sum, mut count, mut all) = ([0.0f32; 3], 0usize, 0usize);
    for pixel in places {
        all += 1;
        if cell_of(inner.width, inner.height, pixel).is_some_and(|cell| inner.cells[cell]) {
            let [r, g, b] = bilinear(picture, pixel);
            sum = [sum[0] + r, sum[1] + g, sum[2] + b];
            count += 1;
        }
    }
    (count * 2 > all).then(|| sum.map(|s| s / count as f32))
}

/// Encoded colour at a place in pixels (first pixel's centre at 0.5), the rim continued.
fn bilinear(picture: &Picture, place: DVec2) -> [f32; 3] {
    let clamp = |i: f64, size: u32| i.clamp(0.0, f64::from(size - 1));
    let (x, y) = (clamp(place.x - 0.5, picture.width), clamp(place.y - 0.5, picture.height));
    // neither is negative
    let (left, top) = (x as u32, y as u32);
    let (right, below) = ((left + 1).min(picture.width - 1), (top + 1).min(picture.height - 1));
    let (s, t) = ((x - f64::from(left)) as f32, (y - f64::from(top)) as f32);
    let upper = [picture.at(left, top), picture.at(right, top)];
    let lower = [picture.at(left, below), picture.at(right, below)];
    let across = |row: &[[u8; 4]; 2], i: usize| f32::from(row[0][i]) * (1.0 - s) + f32::from(row[1][i]) * s;
    let channel = |i: usize| across(&upper, i) * (1.0 - t) + across(&lower, i) * t;
    [channel(0), channel(1), channel(2)]
}

/// Empty cells take the mean of their known neighbours, ring after ring.
fn dilate(cells: &mut [Option<[f32; 3]>], width: usize, height: usize) {
    let grid = Grid { width, height, cells: cells.iter().map(Option::is_some).collect() };
    // known, or about to be
    let mut reached = grid.clone();
    let mut front: Vec<usize> = (0..cells.len()).filter(|&i| cells[i].is_none()).collect();
    front.retain(|&i| grid.neighbours(i).any(|n| grid.cells[n]));
    front.iter().for_each(|&i| reached.cells[i] = true);
    while !front.is_empty() {
        let colours: Vec<[f32; 3]> = front.iter().map(|&i| mean(grid.neighbours(i).filter_map(|n| cells[n]))).collect();
        for (&i, colour) in front.iter().zip(colours) {
            cells[i] = Some(colour);
        }
        let mut next = Vec::new();
        for n in front.iter().flat_map(|&i| grid.neighbours(i)) {
            if !std::mem::replace(&mut reached.cells[n], true) {
                next.push(n);
            }
        }
        front = next;
    }
}

/// The mean of at least one colour.
fn mean(colours: impl Iterator<Item = [f32; 3]>) -> [f32; 3] {
    let ([r, g, b], count) =
        colours.fold(([0.0; 3], 0.0f32), |([r, g, b], count), c| ([r + c[0], g + c[1], b + c[2]], count + 1.0));
    [r / count, g / count, b / count]
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
