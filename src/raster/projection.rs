//! From world coordinates to pixels, for a camera and for the sun.

use super::clip::GUARD;
use crate::base::maths::tanf;
use crate::base::vector::{Affine, Mat3, Vec3};
use crate::frame::Camera;

/// How the third coordinate of a mapped point is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lens {
    /// Mapped points are (x w, y w, w): w is the distance along the viewing axis.
    Perspective,
    /// Mapped points are (x, y, distance).
    Parallel,
}

/// A view of the world in pixels from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Projection {
    /// World to mapped coordinates, see [`Lens`].
    pub map: Affine,
    /// How to read them.
    pub lens: Lens,
    /// The eye (of a camera).
    pub eye: Vec3,
    /// Pixels that a metre covers: at one metre's distance (perspective), anywhere (parallel).
    pub pixels_per_metre: f32,
    /// The orthonormal axes right, down, forward as rows.
    pub axes: Mat3,
    /// Pixels from the upper left corner to the middle.
    pub centre: [f32; 2],
    /// Nearest distance that a camera draws, metres.
    pub near: f32,
    /// Farthest distance that a camera draws, metres.
    pub far: f32,
}

/// A point of the picture: pixels, and a nearness that falls with the distance and is linear over the picture on a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Screen {
    /// Pixels to the right.
    pub x: f32,
    /// Pixels down.
    pub y: f32,
    /// 1 / distance (perspective) or minus the distance (parallel).
    pub nearness: f32,
}

impl Projection {
    /// The projection of a camera onto `width` x `height` pixels. A camera that looks straight up or down keeps +x to
    /// the right.
    pub(super) fn camera(camera: &Camera, width: u32, height: u32) -> Self {
        let forward = (camera.target - camera.position).try_normalize(1e-12).unwrap_or_else(|| -Vec3::z());
        let axes = axes(forward);
        let focal = height as f32 * 0.5 / tanf(camera.field_of_view * 0.5);
        let centre = [width as f32 * 0.5, height as f32 * 0.5];
        let screen = Mat3::new(focal, 0.0, centre[0], 0.0, focal, centre[1], 0.0, 0.0, 1.0);
        let linear = screen * axes;
        let map = Affine { linear, translation: -(linear * camera.position) };
        Self {
            map,
            lens: Lens::Perspective,
            eye: camera.position,
            pixels_per_metre: focal,
            axes,
            centre,
            near: camera.near,
            far: camera.far,
        }
    }

    /// A parallel view along `forward` in which a sphere about `centre` fills a square of `size` pixels.
    pub(super) fn parallel(forward: Vec3, centre: Vec3, radius: f32, size: u32) -> Self {
        let axes = axes(forward);
        let scale = size as f32 / (2.0 * radius);
        let linear = Mat3::from_diagonal(&Vec3::new(scale, scale, 1.0)) * axes;
        let middle = size as f32 * 0.5;
        let translation = Vec3::new(middle, middle, 0.0) - linear * centre;
        let map = Affine { linear, translation };
        Self {
            map,
            lens: Lens::Parallel,
            eye: centre,
            pixels_per_metre: scale,
            axes,
            centre: [middle; 2],
            near: f32::MIN,
            far: f32::MAX,
        }
    }

    /// The unit direction from a camera's eye through a point of the picture.
    pub(super) fn ray(&self, x: f32, y: f32) -> Vec3 {
        let local = Vec3::new(x - self.centre[0], y - self.centre[1], self.pixels_per_metre);
        (self.axes.transpose() * local).normalize()
    }

    /// Metres that a pixel covers at a point.
    pub(super) fn metres(&self, point: Vec3) -> f32 {
        match self.lens {
            Lens::Perspective => (point - self.eye).norm() / self.pixels_per_metre,
            Lens::Parallel => 1.0 / self.pixels_per_metre,
        }
    }

    /// Metres that a pixel covers at the nearest point of a sphere; 0 when the eye is in it.
    pub(super) fn least_metres(&self, centre: Vec3, radius: f32) -> f32 {
        match self.lens {
            Lens::Perspective => ((centre - self.eye).norm() - radius).max(0.0) / self.pixels_per_metre,
            Lens::Parallel => 1.0 / self.pixels_per_metre,
        }
    }

    /// Whether all of a sphere lies where nothing is cut off.
    pub(super) fn holds(&self, centre: Vec3, radius: f32) -> bool {
        if self.lens == Lens::Parallel {
            return true;
        }
        // Rounding of the mapped points is far below a thousandth of what lies this near.
        let ahead = self.map.point(centre).z;
        let near_enough = radius + 0.001 * ahead.abs();
        let farthest = (ahead - near_enough, ahead + near_enough);
        farthest.0 > self.near && farthest.1 < self.far && {
            let reach = (centre - self.eye).norm() + radius;
            reach * self.pixels_per_metre < farthest.0 * (GUARD - self.centre[0].max(self.centre[1]))
        }
    }

    /// Reads a mapped point. In perspective its distance must be positive.
    #[inline(always)]
    pub(super) fn screen(&self, mapped: Vec3) -> Screen {
        match self.lens {
            Lens::Perspective => {
                let nearness = 1.0 / mapped.z;
                Screen { x: mapped.x * nearness, y: mapped.y * nearness, nearness }
            }
            Lens::Parallel => Screen { x: mapped.x, y: mapped.y, nearness: -mapped.z },
        }
    }

    /// A box of pixels (left, top, right, bottom) that holds all of a sphere that lies before a camera, whose view is bounded by the
    /// planes that touch the sphere; `None` when nothing of it does.
    pub(super) fn tangent_bounds(&self, centre: Vec3, radius: f32) -> Option<[f32; 4]> {
        let place = self.axes * (centre - self.eye);
        // Wider by more than rounding turns the tangents where the eye all but touches the sphere.
        let wide = radius * 1.001;
        let ([left, right], [top, bottom]) = (slopes(place.x, place.z, wide)?, slopes(place.y, place.z, wide)?);
        let pixel = |slope: f32, axis: usize, rim: f32| self.centre[axis] + slope * self.pixels_per_metre + rim;
        Some([pixel(left, 0, -1.0), pixel(top, 1, -1.0), pixel(right, 0, 1.0), pixel(bottom, 1, 1.0)])
    }

    /// A box of pixels (left, top, right, bottom) that holds a sphere, and the largest nearness in it; `None` when the
    /// sphere lies behind the camera. A sphere that touches the eye's plane fills the whole picture.
    pub(super) fn sphere_bounds(&self, centre: Vec3, radius: f32) -> Option<([f32; 4], f32)> {
        let mapped = self.map.point(centre);
        let (distance, scale, nearness) = match self.lens {
            Lens::Parallel => (1.0, self.pixels_per_metre, radius - mapped.z),
            Lens::Perspective if mapped.z + radius < self.near || mapped.z - radius > self.far => return None,
            Lens::Perspective if mapped.z - radius < self.near => {
                return Some(([f32::MIN, f32::MIN, f32::MAX, f32::MAX], f32::MAX));
            }
            Lens::Perspective => {
                let nearest = mapped.z - radius;
                (mapped.z, self.pixels_per_metre / nearest, 1.0 / nearest)
            }
        };
        let (x, y) = (mapped.x / distance, mapped.y / distance);
        // Off the axis a sphere's picture is an ellipse, longer by 1 / cos of the angle; the offset from the middle
        // bounds it.
        let offset = ((x - self.centre[0]).abs().max((y - self.centre[1]).abs())) / self.pixels_per_metre;
        let stretch = if self.lens == Lens::Perspective { 1.0 + offset } else { 1.0 };
        let reach = radius * scale * stretch + 1.0;
        Some(([x - reach, y - reach, x + reach, y + reach], nearness))
    }
}

/// The least and the largest slope (across / ahead) of looks from the eye that meet a disc before the eye, between its tangents;
/// endless where the disc reaches behind the eye on that side, none where all of it lies behind.
fn slopes(across: f32, ahead: f32, radius: f32) -> Option<[f32; 2]> {
    let squared = across * across + ahead * ahead - radius * radius;
    if squared <= 0.0 {
        return Some([f32::MIN, f32::MAX]);
    }
    // The way to the middle, turned to either side by the angle whose sine is the radius over the distance.
    let long = squared.sqrt();
    let turned = |radius: f32| [across * long + ahead * radius, ahead * long - across * radius];
    let (left, right) = (turned(-radius), turned(radius));
    // Half the angle between the tangents is below a right angle: only if both look back does all of the disc lie behind. One
    // that looks back may have turned past straight behind, so its side of the eye says nothing.
    if left[1] <= 0.0 && right[1] <= 0.0 {
        return None;
    }
    let slope = |[across, ahead]: [f32; 2], endless: f32| if ahead > 0.0 { across / ahead } else { endless };
    Some([slope(left, f32::MIN), slope(right, f32::MAX)])
}

fn axes(forward: Vec3) -> Mat3 {
    let right = forward.cross(&Vec3::y()).try_normalize(1e-4).unwrap_or_else(Vec3::x);
    let down = forward.cross(&right);
    Mat3::from_rows(&[right.transpose(), down.transpose(), forward.transpose()])
}

/// One map after another: `outer` of `inner`.
#[inline(always)]
pub(super) fn composed(outer: &Affine, inner: &Affine) -> Affine {
    Affine { linear: outer.linear * inner.linear, translation: outer.point(inner.translation) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::sincosf;
    use std::f32::consts::TAU;

    fn projection() -> Projection {
        let camera = Camera {
            position: Vec3::new(0.0, 1.0, 5.0),
            target: Vec3::new(0.0, 1.0, 0.0),
            field_of_view: 0.8,
            near: 0.05,
            far: 1e3,
        };
        Projection::camera(&camera, 400, 200)
    }

    #[test]
    fn the_target_is_in_the_middle_and_up_is_up() {
        let view = projection();
        let at = |x: f32, y: f32| view.screen(view.map.point(Vec3::new(x, y, 0.0)));
        let middle = at(0.0, 1.0);
        assert!((middle.x - 200.0).abs() < 1e-3 && (middle.y - 100.0).abs() < 1e-3);
        assert!((middle.nearness - 0.2).abs() < 1e-6);
        assert!(at(1.0, 2.0).y < 100.0 && at(1.0, 2.0).x > 200.0);
        assert!(at(0.0, 1.0 + 5.0 * tanf(0.4)).y.abs() < 1e-3);
    }

    #[test]
    fn a_ray_goes_through_its_pixel() {
        let view = projection();
        let screen = view.screen(view.map.point(view.eye + view.ray(37.0, 150.0) * 3.0));
        assert!((screen.x - 37.0).abs() < 1e-3 && (screen.y - 150.0).abs() < 1e-3);
    }

    #[test]
    fn bounds_hold_their_sphere() {
        let view = projection();
        for centre in [Vec3::new(1.5, 1.8, 0.0), Vec3::new(-2.0, 0.2, 1.0)] {
            let ([left, top, right, bottom], nearest) = view.sphere_bounds(centre, 0.4).expect("in front");
            for direction in [Vec3::x(), Vec3::y(), Vec3::z(), Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.6, 0.8, 0.0)] {
                for sign in [-0.4, 0.4] {
                    let p = view.screen(view.map.point(centre + direction * sign));
                    assert!(p.x >= left && p.x <= right && p.y >= top && p.y <= bottom && p.nearness <= nearest);
                }
            }
        }
        assert!(view.sphere_bounds(Vec3::new(0.0, 1.0, 9.0), 0.4).is_none());
    }

    #[test]
    fn tangents_hold_what_is_seen_of_a_sphere_beside_the_eye_and_little_more() {
        let view = projection();
        let pixel = |x: f32| x.clamp(0.0, 400.0);
        // Beside the eye and reaching behind it, to the right and to the left; about the eye; before it.
        let places = [(1.0, 5.2, 0.9), (-1.0, 5.2, 0.9), (0.1, 5.0, 0.4), (0.3, 2.0, 0.3), (0.9, 4.4, 0.7)];
        for (x, z, radius) in places {
            let [left, _, right, _] = view.tangent_bounds(Vec3::new(x, 1.0, z), radius).expect("before the eye");
            let seen = (0..3600).filter_map(|step| {
                let (sine, cosine) = sincosf(step as f32 * (TAU / 3600.0));
                let mapped = view.map.point(Vec3::new(x + radius * sine, 1.0, z + radius * cosine));
                (mapped.z > view.near).then(|| pixel(view.screen(mapped).x))
            });
            let (low, high) = seen.fold((400.0f32, 0.0f32), |(low, high), x| (low.min(x), high.max(x)));
            // About the eye every look meets it.
            let (low, high) = if radius == 0.4 { (0.0, 400.0) } else { (low, high) };
            assert!(pixel(left) <= low && pixel(left) > low - 3.0, "{x} {z}: {left} {low}");
            assert!(pixel(right) >= high && pixel(right) < high + 3.0, "{x} {z}: {right} {high}");
        }
        assert!(view.tangent_bounds(Vec3::new(1.0, 1.0, 9.0), 0.4).is_none());
    }

    #[test]
    fn slopes_hold_every_look_that_meets_a_disc() {
        // Discs all about the eye, up to where it all but touches them.
        for (step, share) in (0..360).flat_map(|step| [0.02f32, 0.3, 0.8, 0.99, 0.9999].map(|share| (step, share))) {
            let (sine, cosine) = sincosf(step as f32 * (TAU / 360.0));
            let looks = (-899..900).map(|look| libm::tanf(look as f32 * (0.5 * std::f32::consts::PI / 900.0)));
            // A look along (slope, 1) meets the disc where it passes its middle within the radius and ahead.
            let met: Vec<f32> = looks
                .filter(|slope| {
                    let length = (1.0 + slope * slope).sqrt();
                    let (along, off) = ((sine * slope + cosine) / length, (sine - cosine * slope).abs() / length);
                    along > 0.0 && off < share
                })
                .collect();
            let found = slopes(sine, cosine, share);
            let holds = |slope: &f32| found.is_some_and(|[low, high]| low <= *slope + 1e-3 && *slope <= high + 1e-3);
            assert!(met.iter().all(holds), "{step} {share}: {found:?}");
            assert!(found.is_some() || met.is_empty());
        }
    }

    #[test]
    fn a_parallel_view_keeps_sizes() {
        let view = Projection::parallel(-Vec3::z(), Vec3::new(0.0, 2.0, 0.0), 4.0, 100);
        let screen = view.screen(view.map.point(Vec3::new(1.0, 2.0, 3.0)));
        assert!((screen.x - 62.5).abs() < 1e-4 && (screen.y - 50.0).abs() < 1e-4);
        let nearer = view.screen(view.map.point(Vec3::new(1.0, 2.0, 4.0)));
        assert!(nearer.nearness > screen.nearness);
    }
}
