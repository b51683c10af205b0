//! Meshes of the frame as glTF meshes: one for each model, a primitive for each part; and models baked together.

use super::ExportError;
use super::document::{Document, Vertices};
use crate::base::mesh::Mesh;
use crate::base::vector::Affine;
use gltf_json::buffer::Target;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Index, Material};
use std::collections::BTreeMap;

impl Document<'_> {
    /// The glTF mesh of a model; `None` when it has no triangles, which glTF cannot say.
    pub(super) fn model(&mut self, number: u32) -> Result<Option<Index<gltf_json::Mesh>>, ExportError> {
        if let Some(&known) = self.models.get(&number) {
            return Ok(known);
        }
        let model = &self.frame.models[number as usize];
        let mut primitives = Vec::new();
        for part in &model.parts {
            if !self.frame.meshes[part.mesh as usize].triangles.is_empty() {
                let material = self.material(part.material)?;
                primitives.push(primitive(self.shared_vertices(part.mesh), material));
            }
        }
        let mesh = (!primitives.is_empty()).then(|| self.mesh(&model.name, primitives));
        self.models.insert(number, mesh);
        Ok(mesh)
    }

    /// One mesh of all the given instances, a primitive for each material; `None` without triangles.
    pub(super) fn baked(
        &mut self,
        name: &str,
        instances: &[(u32, Affine)],
    ) -> Result<Option<Index<gltf_json::Mesh>>, ExportError> {
        let mut primitives = Vec::new();
        for (material, parts) in parts_by_material(self, instances) {
            let mut all = Mesh::default();
            parts
                .iter()
                .for_each(|(mesh, transform)| all.append(&moved(&self.frame.meshes[*mesh as usize], transform)));
            if !all.triangles.is_empty() {
                let material = self.material(material)?;
                primitives.push(primitive(self.write_vertices(&all), material));
            }
        }
        Ok((!primitives.is_empty()).then(|| self.mesh(name, primitives)))
    }

    /// Triangles of a model.
    pub(super) fn model_triangles(&self, number: u32) -> u64 {
        let parts = &self.frame.models[number as usize].parts;
        parts.iter().map(|part| self.frame.meshes[part.mesh as usize].triangles.len() as u64).sum()
    }

    fn mesh(&mut self, name: &str, primitives: Vec<Primitive>) -> Index<gltf_json::Mesh> {
        let name = Some(self.mesh_names.give(name));
        let (extensions, extras) = (None, Default::default());
        self.root.push(gltf_json::Mesh { extensions, extras, name, primitives, weights: None })
    }

    fn shared_vertices(&mut self, number: u32) -> Vertices {
        if let Some(&known) = self.vertices.get(&number) {
            return known;
        }
        let frame = self.frame;
        let written = self.write_vertices(&frame.meshes[number as usize]);
        self.vertices.insert(number, written);
        written
    }

    fn write_vertices(&mut self, mesh: &Mesh) -> Vertices {
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|&p| p.into()).collect();
        let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|&n| n.into()).collect();
        let uvs: Vec<[f32; 2]> = mesh.uvs.iter().map(|&uv| uv.into()).collect();
        let (root, buffer) = (&mut self.root, &mut self.buffer);
        Vertices {
            positions: buffer.positions(root, &positions),
            normals: buffer.floats(root, &normals, Some(Target::ArrayBuffer)),
            uvs: buffer.floats(root, &uvs, Some(Target::ArrayBuffer)),
            indices: buffer.indices(root, &mesh.triangles, mesh.positions.len()),
        }
    }
}

type Parts = BTreeMap<u32, Vec<(u32, Affine)>>;

fn parts_by_material(document: &Document<'_>, instances: &[(u32, Affine)]) -> Parts {
    let mut parts = Parts::new();
    for &(model, transform) in instances {
        for part in &document.frame.models[model as usize].parts {
            parts.entry(part.material).or_default().push((part.mesh, transform));
        }
    }
    parts
}

/// The mesh at its place. The scale is one for all axes, so normals turn as positions do.
fn moved(mesh: &Mesh, transform: &Affine) -> Mesh {
    Mesh {
        positions: mesh.positions.iter().map(|&p| transform.point(p)).collect(),
        normals: mesh.normals.iter().map(|n| (transform.linear * n).normalize()).collect(),
        uvs: mesh.uvs.clone(),
        triangles: mesh.triangles.clone(),
    }
}

fn primitive(vertices: Vertices, material: Index<Material>) -> Primitive {
    Primitive {
        attributes: BTreeMap::from([
            (Valid(Semantic::Positions), vertices.positions),
            (Valid(Semantic::Normals), vertices.normals),
            (Valid(Semantic::TexCoords(0)), vertices.uvs),
        ]),
        extensions: None,
        extras: Default::default(),
        indices: Some(vertices.indices),
        material: Some(material),
        mode: Valid(Mode::Triangles),
        targets: None,
    }
}
