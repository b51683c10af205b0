//! The user's scan laid out by the mesh's texture coordinates, and greys out of a painted mask.

use crate::base::flat_mesh::FlatMesh;
use crate::base::picture::Picture;
use crate::base::vector::{DVec2, Vec2};
use crate::leaf::grid::Grid;
use crate::leaf::trace::Trace;

/// Pixels along a side of the laid-out scan.
const SIDE: usize = 512;
/// Samples of a texel along each axis.
const TAPS: usize = 3;

/// The scan, 512 x 512, opaque; where the leaf is not, the colour of the leaf's nearest rim goes on.
pub fn laid_out(picture: &Picture, trace: &Trace, mesh: &FlatMesh) -> Picture {
    let inner = eroded(&trace.shown);
    let mut cells: Vec<Option<[f32; 3]>> = (0..SIDE * SIDE).map(|i| texel(picture, &inner, trace, mesh, i)).collect();
    dilate(&mut cells);
    let code = |c: Option<[f32; 3]>| {
        let [r, g, b] = c.unwrap_or([0.0; 3]).map(|x| (x + 0.5) as u8);
        [r, g, b, 255]
    };
    Picture { width: SIDE as u32, height: SIDE as u32, pixels: cells.into_iter().map(code).collect() }
}

/// The blade's colour without its outermost pixels, which blur and shadow mix with the background's.
fn eroded(shown: &Grid<bool>) -> Grid<bool> {
    let side = shown.width.max(shown.height) as f64;
    let rim = (0.0025 * side).max(2.5);
    shown.map(|c| !c).squared_distances().map(|d| d > rim * rim)
}

/// Mean of the leaf's colours under a texel; `None` when most of it is background.
fn texel(picture: &Picture, inner: &Grid<bool>, trace: &Trace, mesh: &FlatMesh, number: usize) -> Option<[f32; 3]> {
    let (mut sum, mut count) = ([0.0f32; 3], 0usize);
    for tap in 0..TAPS * TAPS {
        let place = |cell: usize, tap: usize| (cell as f64 + (tap as f64 + 0.5) / TAPS as f64) / SIDE as f64;
        let (u, v) = (place(number % SIDE, tap % TAPS), place(number / SIDE, tap / TAPS));
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
    (count * 2 > TAPS * TAPS).then(|| sum.map(|s| s / count as f32))
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
fn dilate(cells: &mut [Option<[f32; 3]>]) {
    let grid = Grid { width: SIDE, height: SIDE, cells: cells.iter().map(Option::is_some).collect() };
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
    fn dilation_fills_everything_with_what_is_there() {
        let mut cells = vec![None; SIDE * SIDE];
        cells[SIDE * 100 + 100] = Some([10.0, 20.0, 30.0]);
        dilate(&mut cells);
        assert!(cells.iter().all(|c| *c == Some([10.0, 20.0, 30.0])));
    }
}
