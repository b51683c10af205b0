//! Textures as pyramids of linear colour (Williams 1983).

use crate::base::maths::{log2f, srgb_to_linear};
use crate::base::vector::Vec2;
use crate::frame::Texture;

/// A texture with all its halvings.
#[derive(Clone, Debug)]
pub(super) struct MipMap {
    levels: Vec<Level>,
    repeat: bool,
}

#[derive(Clone, Debug)]
struct Level {
    width: u32,
    height: u32,
    texels: Vec<[f32; 3]>,
}

impl MipMap {
    /// Decodes a texture and halves it down to one texel.
    pub(super) fn new(texture: &Texture) -> Self {
        Self::decoded(texture, |code| srgb_to_linear(code as f32 / 255.0))
    }

    /// The same for normals, whose codes are plain numbers.
    pub(super) fn of_normals(texture: &Texture) -> Self {
        Self::decoded(texture, |code| (code as f32 - 128.0) / 127.0)
    }

    fn decoded(texture: &Texture, decode: impl Fn(u32) -> f32) -> Self {
        let table: Vec<f32> = (0..256u32).map(decode).collect();
        let texels = texture.pixels.iter().map(|p| p.map(|code| table[usize::from(code)])).collect();
        let mut levels = vec![Level { width: texture.width, height: texture.height, texels }];
        while let Some(last) = levels.last().filter(|level| level.width > 1 || level.height > 1) {
            let halved = last.halved();
            levels.push(halved);
        }
        Self { levels, repeat: texture.repeat }
    }

    /// The colour at `uv`, averaged over about `footprint` (in texture units), between the two nearest levels.
    pub(super) fn sample(&self, uv: Vec2, footprint: f32) -> [f32; 3] {
        let texels = footprint * (self.levels[0].width as f32 * self.levels[0].height as f32).sqrt();
        let level = if texels > 1.0 { log2f(texels) } else { 0.0 };
        let last = self.levels.len() - 1;
        let lower = (level as usize).min(last);
        let coarse = self.levels[(lower + 1).min(last)].bilinear(uv, self.repeat);
        let fine = self.levels[lower].bilinear(uv, self.repeat);
        let t = (level - lower as f32).clamp(0.0, 1.0);
        std::array::from_fn(|k| fine[k] + (coarse[k] - fine[k]) * t)
    }

    /// The mean of the whole texture.
    pub(super) fn mean(&self) -> [f32; 3] {
        self.levels.last().map_or([0.0; 3], |level| level.texels[0])
    }
}

impl Level {
    fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let (sx, sy) = (self.width / width, self.height / height);
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0f32; 3];
                for (dx, dy) in (0..sy).flat_map(|dy| (0..sx).map(move |dx| (dx, dy))) {
                    let texel = self.texels[((y * sy + dy) * self.width + x * sx + dx) as usize];
                    sum = std::array::from_fn(|k| sum[k] + texel[k]);
                }
                texels.push(sum.map(|s| s / (sx * sy) as f32));
            }
        }
        Self { width, height, texels }
    }

    fn bilinear(&self, uv: Vec2, repeat: bool) -> [f32; 3] {
        // Into one repeat first: a long branch counts thousands of them, and texels would lose their fractions.
        let uv = uv.map(|c| if repeat { c - c.floor() } else { c.clamp(0.0, 1.0) });
        let x = uv.x * self.width as f32 - 0.5;
        let y = uv.y * self.height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let column = |offset: i32| wrapped(x0 as i32 + offset, self.width, repeat);
        let row = |offset: i32| wrapped(y0 as i32 + offset, self.height, repeat) * self.width as usize;
        let (left, right, up, down) = (column(0), column(1), row(0), row(1));
        let [a, b, c, d] = [up + left, up + right, down + left, down + right].map(|i| self.texels[i]);
        std::array::from_fn(|k| (a[k] * (1.0 - fx) + b[k] * fx) * (1.0 - fy) + (c[k] * (1.0 - fx) + d[k] * fx) * fy)
    }
}

fn wrapped(index: i32, size: u32, repeat: bool) -> usize {
    let size = size as i32;
    (if repeat { index.rem_euclid(size) } else { index.clamp(0, size - 1) }) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checks() -> Texture {
        let pixels = (0..16).map(|i| if (i % 4 + i / 4) % 2 == 0 { [255; 3] } else { [0; 3] }).collect();
        Texture { name: "checks".into(), width: 4, height: 4, pixels, repeat: true }
    }

    #[test]
    fn the_mean_is_linear_light() {
        let map = MipMap::new(&checks());
        assert!((map.mean()[0] - 0.5).abs() < 1e-6);
        assert!((map.sample(Vec2::new(0.3, 0.7), 4.0)[1] - 0.5).abs() < 1e-6);
    }

    #[test]
    fn texel_centres_are_exact_and_the_rim_wraps() {
        let map = MipMap::new(&checks());
        assert_eq!(map.sample(Vec2::new(0.125, 0.125), 0.0), [1.0; 3]);
        assert_eq!(map.sample(Vec2::new(1.375, -0.875), 0.0), [0.0; 3]);
    }
}
