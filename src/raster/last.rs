//! The frame that was drawn last, and what of it stands in the next: tiles of the picture and of the shadow map that show the
//! same things in the same light, the light in the crowns. Whatever is kept was made of the same numbers, so that a frame of a
//! run has the same bytes as by itself. Where only the camera moves the light stays: the map of shadows and that in the crowns.

use super::bins::{Bins, Item};
use super::canopy::Canopy;
use super::cluster::ClusteredMesh;
use super::distant_wood::Palette;
use super::drawn::{Drawn, Fingerprints};
use super::reads::Reads;
use super::shadow::ShadowMap;
use super::texture::MipMap;
use super::tile::Pixels;
use super::{Shared, of_surroundings};
use crate::frame::{Background, Camera, Frame, Ground, Instance, Material, Model, Sky, Sun, View, Wood};
use std::sync::Arc;

/// Whether what has a number is among what is the same.
fn is(same: &[bool], number: u32) -> bool {
    same.get(number as usize).is_some_and(|same| *same)
}

/// A tile as it was drawn, with what it read.
pub(super) struct DrawnTile {
    pub pixels: Pixels,
    pub reads: Reads,
}

/// What every tile may read, and what few frames of a run change.
struct Scenery {
    camera: Camera,
    sun: Sun,
    sky: Sky,
    background: Background,
    view: View,
    /// Without its season and its cover.
    ground: Option<Ground>,
    textures: Vec<Arc<MipMap>>,
}

/// What changes with the season where nothing stands.
#[derive(PartialEq)]
struct Season {
    /// How far the grass has gone into its winter rest.
    rest: Option<f32>,
    /// Share of the wood's leaves that are gone, and what its trees wear.
    wood: (Option<f32>, Palette),
}

/// Most instances of a frame whose tiles are kept: with more, hardly a tile stays the same, and what tells so takes memory.
const MOST: usize = 1 << 18;

/// A frame that was drawn, but for what its scene keeps anyway.
pub(super) struct Last {
    scenery: Scenery,
    season: Season,
    fingerprints: Fingerprints,
    models: Vec<Model>,
    materials: Vec<Material>,
    meshes: Vec<Arc<ClusteredMesh>>,
    textures: Vec<Arc<MipMap>>,
    canopy: Option<Arc<Canopy>>,
    shadow: Option<Arc<ShadowMap>>,
    picture: Option<LastPicture>,
}

/// Whether the tiles of a frame of so many instances are kept.
pub(super) fn are_tiles_kept(instances: usize) -> bool {
    instances <= MOST
}

/// The picture of such a frame, and of what it was drawn.
struct LastPicture {
    instances: Drawn<'static>,
    bins: Bins,
    tiles: Vec<Arc<DrawnTile>>,
}

/// What is the same in the next frame.
pub(super) struct Same<'a> {
    last: &'a Last,
    instances: &'a Drawn<'a>,
    meshes: Vec<bool>,
    materials: Vec<bool>,
    /// Whether the picture is taken from the same place: the light of a scene does not ask for it.
    is_same_camera: bool,
}

/// What of the light is not the same in the next frame.
struct Changed {
    wood: bool,
    rest: bool,
    crowns: bool,
    open: bool,
    /// By the tiles of the shadow map, see [`Reads::has_shadow_of`]; none when it is another map altogether.
    shadow: Option<Vec<f32>>,
}

impl Scenery {
    fn of(frame: &Frame, textures: &[Arc<MipMap>]) -> Self {
        // All fields by name, so that none that is added is forgotten; the tiles' items tell of those that are passed over.
        let Frame {
            meshes: _,
            textures: _,
            materials: _,
            models: _,
            instances: _,
            fallen: _,
            camera,
            sun,
            sky,
            ground,
            background,
            view,
        } = frame;
        let ground = ground.as_ref().map(|ground| Ground {
            wood: ground.wood.map(|wood| Wood { bareness: 0.0, ..wood }),
            dormant: 0.0,
            feet: ground.feet.clone(),
            cover: Vec::new(),
            ..*ground
        });
        let textures = of_surroundings(frame).map(|number| textures[number as usize].clone()).collect();
        Self { camera: *camera, sun: *sun, sky: *sky, background: *background, view: *view, ground, textures }
    }

    /// Whether all but the camera is the same.
    fn is_same(&self, other: &Self) -> bool {
        let textures = || self.textures.iter().zip(&other.textures);
        self.sun == other.sun
            && self.sky == other.sky
            && self.background == other.background
            && self.view == other.view
            && self.ground == other.ground
            && self.textures.len() == other.textures.len()
            && textures().all(|(one, other)| Arc::ptr_eq(one, other))
    }
}

impl Season {
    fn of(frame: &Frame, palette: &Palette) -> Self {
        let ground = frame.ground.as_ref();
        let bareness = ground.and_then(|ground| ground.wood).map(|wood| wood.bareness);
        Self { rest: ground.map(|ground| ground.dormant), wood: (bareness, palette.clone()) }
    }
}

impl Last {
    /// The frame that these were made for.
    pub(super) fn of(shared: Shared<'_>, bins: Bins, tiles: Vec<Arc<DrawnTile>>) -> Self {
        let Shared { frame, instances, fingerprints, meshes, textures, atmosphere, canopy, shadow, .. } = shared;
        let is_kept = are_tiles_kept(instances.all.len());
        Self {
            scenery: Scenery::of(frame, &textures),
            season: Season::of(frame, &atmosphere.wood),
            fingerprints,
            models: frame.models.clone(),
            materials: frame.materials.clone(),
            meshes,
            textures,
            canopy,
            shadow,
            picture: is_kept.then(|| LastPicture { instances: instances.kept(), bins, tiles }),
        }
    }

    /// What is the same in a frame of these meshes and textures; none where nothing of the last one serves.
    pub(super) fn same<'a>(
        &'a self,
        frame: &Frame,
        instances: &'a Drawn<'a>,
        (meshes, textures): (&[Arc<ClusteredMesh>], &[Arc<MipMap>]),
    ) -> Option<Same<'a>> {
        let scenery = Scenery::of(frame, textures);
        if !self.scenery.is_same(&scenery) {
            return None;
        }
        let is_read = |number: u32| {
            let [then, now] = [&self.textures[..], textures].map(|textures| textures.get(number as usize));
            then.zip(now).is_some_and(|(then, now)| Arc::ptr_eq(then, now))
        };
        let material = |(then, now): (&Material, &Material)| {
            let textures = [now.reflected, now.transmitted, now.behind, now.relief];
            then == now && textures.into_iter().flatten().all(is_read)
        };
        Some(Same {
            last: self,
            instances,
            meshes: self.meshes.iter().zip(meshes).map(|(then, now)| Arc::ptr_eq(then, now)).collect(),
            materials: self.materials.iter().zip(&frame.materials).map(material).collect(),
            is_same_camera: self.scenery.camera == scenery.camera,
        })
    }
}

impl Same<'_> {
    /// Whether a cluster is the same at the same place; `salt` if what its instance is known by counts too.
    fn item(&self, kept: &LastPicture, now: &Item, then: &Item, salt: bool) -> bool {
        let (one, other) = (&self.instances.all[now.instance as usize], &kept.instances.all[then.instance as usize]);
        let places = |item: &Item| (item.mesh, item.level, item.cluster, item.material);
        places(now) == places(then)
            && is(&self.meshes, now.mesh)
            && is(&self.materials, now.material)
            && one.transform == other.transform
            && one.leaf.is_some() == other.leaf.is_some()
            && (!salt || self.instances.salt(now.instance) == kept.instances.salt(then.instance))
    }

    /// Whether some of a frame's instances are drawn as those of the same numbers were.
    fn are_drawn_alike(&self, frame: &Frame, instances: &[Instance]) -> bool {
        let is_same_model = |(then, now): (&Model, &Model)| {
            then.parts == now.parts
                && now.parts.iter().all(|part| is(&self.meshes, part.mesh) && is(&self.materials, part.material))
        };
        let models: Vec<bool> = self.last.models.iter().zip(&frame.models).map(is_same_model).collect();
        instances.iter().all(|one| is(&models, one.model))
    }

    /// The light in the crowns, where all that stands is the same.
    pub(super) fn canopy(&self, frame: &Frame, now: Fingerprints) -> Option<Option<Arc<Canopy>>> {
        let is_same = self.last.fingerprints.standing == now.standing && self.are_drawn_alike(frame, frame.standing());
        is_same.then(|| self.last.canopy.clone())
    }

    /// The map of shadows, where all that stands and lies is the same.
    pub(super) fn whole_shadow(&self, frame: &Frame, now: Fingerprints) -> Option<Option<Arc<ShadowMap>>> {
        let is_same = self.last.fingerprints == now && self.are_drawn_alike(frame, &frame.instances);
        is_same.then(|| self.last.shadow.clone())
    }

    /// The map of shadows as it was.
    pub(super) fn shadow(&self) -> Option<&ShadowMap> {
        self.last.shadow.as_deref()
    }

    /// Whether a tile of the shadow map is drawn of the same clusters.
    pub(super) fn is_shadow_tile(&self, [now, then]: [&Bins; 2], tile: usize) -> bool {
        let Some(kept) = &self.last.picture else { return false };
        now.holds_as(then, tile, |now, then| self.item(kept, now, then, false))
    }

    /// How many of a picture's tiles are those of the last.
    pub(super) fn kept(&self, tiles: &[Arc<DrawnTile>]) -> usize {
        let then = self.last.picture.iter().flat_map(|kept| &kept.tiles);
        then.zip(tiles).filter(|(then, now)| Arc::ptr_eq(then, now)).count()
    }

    /// The tiles of the picture that look as they did, by their numbers.
    pub(super) fn tiles<'b>(
        &'b self,
        shared: &'b Shared<'_>,
        bins: &'b Bins,
    ) -> impl Fn(usize) -> Option<Arc<DrawnTile>> + Sync + 'b {
        let kept = self.last.picture.as_ref().filter(|_| self.is_same_camera);
        let known = kept.map(|kept| (kept, Changed::of(self, shared)));
        move |number| {
            let (kept, changed) = known.as_ref()?;
            let tile = &kept.tiles[number];
            let is_same = |now: &Item, then: &Item| self.item(kept, now, then, tile.reads.salt);
            (changed.leaves(&tile.reads) && bins.holds_as(&kept.bins, number, is_same)).then(|| tile.clone())
        }
    }
}

impl Changed {
    fn of(same: &Same<'_>, shared: &Shared<'_>) -> Self {
        let (last, season) = (same.last, Season::of(shared.frame, &shared.atmosphere.wood));
        let (crowns, open) = match (&last.canopy, &shared.canopy) {
            (None, None) => (false, false),
            (Some(then), Some(now)) => (!Arc::ptr_eq(then, now), !then.has_extent_of(now)),
            _ => (true, true),
        };
        let shadow = match (&last.shadow, &shared.shadow) {
            (None, None) => Some(Vec::new()),
            (Some(then), Some(now)) => now.changes(then),
            _ => None,
        };
        Self { wood: season.wood != last.season.wood, rest: season.rest != last.season.rest, crowns, open, shadow }
    }

    /// Whether nothing that was read has changed.
    fn leaves(&self, reads: &Reads) -> bool {
        let is_shadow_changed = || self.shadow.as_ref().is_none_or(|changed| reads.has_shadow_of(changed));
        !(reads.wood && self.wood
            || reads.rest && self.rest
            || reads.crowns && self.crowns
            || reads.open && self.open
            || reads.sun && is_shadow_changed())
    }
}
