//! What lies behind a block of pixels: sky and ground, found once a block where they are even.

use super::Prepared;
use super::even::Even;
use super::ground::GroundLight;

/// The backdrop of one block.
pub(super) struct Backdrop<'a> {
    prepared: &'a Prepared<'a>,
    /// Upper left corner of the block, pixels.
    corner: [f32; 2],
    sky: Known<3>,
    light: Known<{ GroundLight::VALUES }>,
    patches: Known<4>,
}

/// Values that are looked for when they are first asked for.
enum Known<const N: usize> {
    NotYet,
    Even(Even<N>),
    Uneven,
}

impl<const N: usize> Known<N> {
    /// The values at a place of the picture.
    fn at(&mut self, corner: [f32; 2], at: [f32; 2], find: impl Fn([f32; 2]) -> [f32; N]) -> [f32; N] {
        if let Self::NotYet = self {
            *self = Even::over(corner, &find).map_or(Self::Uneven, Self::Even);
        }
        match self {
            Self::Even(even) => even.at([at[0] - corner[0], at[1] - corner[1]]),
            _ => find(at),
        }
    }
}

impl<'a> Backdrop<'a> {
    /// The backdrop of the block at `corner`, pixels.
    pub(super) fn new(prepared: &'a Prepared<'a>, corner: [f32; 2]) -> Self {
        Self { prepared, corner, sky: Known::NotYet, light: Known::NotYet, patches: Known::NotYet }
    }

    /// Radiance of the sky at a place of the picture.
    pub(super) fn sky(&mut self, at: [f32; 2]) -> [f32; 3] {
        let prepared = self.prepared;
        self.sky.at(self.corner, at, |at| prepared.sky(at))
    }

    /// Radiance of the ground at a place of the picture below the horizon.
    pub(super) fn ground(&mut self, at: [f32; 2]) -> [f32; 3] {
        let prepared = self.prepared;
        let light = self.light.at(self.corner, at, |at| prepared.ground_light(at).values());
        let patches = self.patches.at(self.corner, at, |at| prepared.ground_patches(at));
        prepared.ground(at, &GroundLight::of(light), patches)
    }
}
