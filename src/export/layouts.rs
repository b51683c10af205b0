//! The nodes of the three layouts. Each gives the children of the one root node.

use super::document::Document;
use super::placement::Placement;
use super::{ExportError, Layout};
use crate::base::vector::Affine;
use crate::frame::Instance;
use gltf_json::scene::UnitQuaternion;
use gltf_json::{Index, Node};
use serde_json::json;
use std::collections::BTreeMap;

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

type Children = Result<Vec<Index<Node>>, ExportError>;

impl Document<'_> {
    /// Writes everything that stands in the frame; `placements` has one entry for each instance.
    pub(super) fn children(&mut self, layout: Layout, placements: &[Placement]) -> Children {
        match layout {
            Layout::Nodes => self.nodes(placements),
            Layout::Merged => self.merged(),
            Layout::Instanced => self.instanced(placements),
        }
    }

    fn nodes(&mut self, placements: &[Placement]) -> Children {
        let mut children = Vec::new();
        for (number, placement) in placements.iter().enumerate() {
            children.extend(self.single(number, placement)?);
        }
        Ok(children)
    }

    /// A node for one instance, named after its leaf (its stable id in hexadecimal) or its model. Leaves that have fallen have
    /// another name than those that hang.
    fn single(&mut self, number: usize, placement: &Placement) -> Result<Option<Index<Node>>, ExportError> {
        let instance: &Instance = &self.frame.instances[number];
        let kind = if number < self.frame.standing().len() { "leaf" } else { "fallen" };
        let Some(mesh) = self.model(instance.model)? else { return Ok(None) };
        self.triangles += self.model_triangles(instance.model);
        let model_name = &self.frame.models[instance.model as usize].name;
        let name = instance.leaf.map_or_else(|| model_name.clone(), |id| format!("{kind}_{id:016x}"));
        let index = self.node(&name, Some(mesh));
        place(&mut self.root.nodes[index.value()], placement);
        Ok(Some(index))
    }

    fn merged(&mut self) -> Children {
        let mut children = Vec::new();
        let frame = self.frame;
        let (standing, fallen) = (frame.standing(), &frame.instances[frame.standing().len()..]);
        for (name, instances, leaves) in
            [("wood", standing, false), ("leaves", standing, true), ("litter", fallen, true)]
        {
            let instances: Vec<(u32, Affine)> = instances
                .iter()
                .filter(|instance| instance.leaf.is_some() == leaves)
                .map(|instance| (instance.model, instance.transform))
                .collect();
            if let Some(mesh) = self.baked(name, &instances)? {
                self.triangles += instances.iter().map(|&(model, _)| self.model_triangles(model)).sum::<u64>();
                children.push(self.node(name, Some(mesh)));
            }
        }
        Ok(children)
    }

    /// One node for each model, in the order in which models first occur; a model that stands once is a plain node.
    fn instanced(&mut self, placements: &[Placement]) -> Children {
        let mut order = Vec::new();
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (number, instance) in self.frame.instances.iter().enumerate() {
            let list = members.entry(instance.model).or_default();
            if list.is_empty() {
                order.push(instance.model);
            }
            list.push(number);
        }
        let mut children = Vec::new();
        for model in order {
            match members[&model].as_slice() {
                &[only] => children.extend(self.single(only, &placements[only])?),
                many => children.extend(self.batch(model, many, placements)?),
            }
        }
        Ok(children)
    }

    fn batch(
        &mut self,
        model: u32,
        members: &[usize],
        placements: &[Placement],
    ) -> Result<Option<Index<Node>>, ExportError> {
        let Some(mesh) = self.model(model)? else { return Ok(None) };
        self.triangles += self.model_triangles(model) * members.len() as u64;
        let translations: Vec<[f32; 3]> = members.iter().map(|&i| placements[i].translation).collect();
        let rotations: Vec<[f32; 4]> = members.iter().map(|&i| placements[i].rotation).collect();
        let scales: Vec<[f32; 3]> = members.iter().map(|&i| [placements[i].scale; 3]).collect();
        let (root, buffer) = (&mut self.root, &mut self.buffer);
        let attributes = json!({
            "ROTATION": buffer.floats(root, &rotations, None).value(),
            "SCALE": buffer.floats(root, &scales, None).value(),
            "TRANSLATION": buffer.floats(root, &translations, None).value(),
        });
        let name = self.frame.models[model as usize].name.clone();
        let index = self.node(&name, Some(mesh));
        let extensions = self.root.nodes[index.value()].extensions.get_or_insert_default();
        extensions.others.insert(INSTANCING.to_owned(), json!({ "attributes": attributes }));
        self.extensions.insert(INSTANCING);
        // Required, since a reader that ignores it shows one leaf and says nothing.
        self.root.extensions_required = vec![INSTANCING.to_owned()];
        Ok(Some(index))
    }
}

fn place(node: &mut Node, placement: &Placement) {
    node.translation = (placement.translation != [0.0; 3]).then_some(placement.translation);
    node.rotation = (placement.rotation != [0.0, 0.0, 0.0, 1.0]).then_some(UnitQuaternion(placement.rotation));
    node.scale = (placement.scale != 1.0).then_some([placement.scale; 3]);
}
