//! A glTF file under construction: its JSON tree, its buffer, and what has been written of the frame so far.

use super::buffer::Buffer;
use super::names::Names;
use crate::frame::Frame;
use gltf_json::accessor::Accessor;
use gltf_json::texture::Sampler;
use gltf_json::{Index, Material, Mesh, Node, Root, Texture};
use std::collections::{BTreeMap, BTreeSet};

/// The vertex attributes and indices of one mesh of the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertices {
    pub(super) positions: Index<Accessor>,
    pub(super) normals: Index<Accessor>,
    pub(super) uvs: Index<Accessor>,
    pub(super) indices: Index<Accessor>,
}

/// Which picture a texture of the file shows: a texture of the frame, as it is or scaled for a material's transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Shown {
    /// Texture of that number.
    Reflected(u32),
    /// Texture of that number, scaled for the material of the second.
    Transmitted(u32, u32),
    /// Texture of that number, normals.
    Relief(u32),
}

/// The file and, by numbers of the frame, what it holds already. Everything is written when it is first used.
pub(super) struct Document<'a> {
    pub(super) frame: &'a Frame,
    pub(super) root: Root,
    pub(super) buffer: Buffer,
    pub(super) vertices: BTreeMap<u32, Vertices>,
    pub(super) materials: BTreeMap<u32, Index<Material>>,
    pub(super) textures: BTreeMap<Shown, Index<Texture>>,
    pub(super) samplers: BTreeMap<bool, Index<Sampler>>,
    pub(super) models: BTreeMap<u32, Option<Index<Mesh>>>,
    pub(super) extensions: BTreeSet<&'static str>,
    pub(super) node_names: Names,
    pub(super) mesh_names: Names,
    pub(super) material_names: Names,
    pub(super) texture_names: Names,
    /// Triangles that a viewer draws.
    pub(super) triangles: u64,
}

impl<'a> Document<'a> {
    /// An empty file.
    pub(super) fn new(frame: &'a Frame) -> Self {
        Self {
            frame,
            root: Root::default(),
            buffer: Buffer::default(),
            vertices: BTreeMap::new(),
            materials: BTreeMap::new(),
            textures: BTreeMap::new(),
            samplers: BTreeMap::new(),
            models: BTreeMap::new(),
            extensions: BTreeSet::new(),
            node_names: Names::default(),
            mesh_names: Names::default(),
            material_names: Names::default(),
            texture_names: Names::default(),
            triangles: 0,
        }
    }

    /// Adds a node of a mesh, not yet anyone's child.
    pub(super) fn node(&mut self, wanted_name: &str, mesh: Option<Index<Mesh>>) -> Index<Node> {
        let name = Some(self.node_names.give(wanted_name));
        self.root.push(Node { mesh, name, ..Node::default() })
    }
}
