//! The binary half of a GLB: one buffer, cut into views that start at multiples of four bytes, read through accessors.

use gltf_json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::validation::Checked::Valid;
use gltf_json::validation::USize64;
use gltf_json::{Index, Root, Value};

/// Bytes of a view from which room is made for it alone.
const LARGE: usize = 1 << 20;

/// The bytes written so far.
#[derive(Debug, Default)]
pub(super) struct Buffer {
    /// Padded to a multiple of four after each view.
    pub(super) bytes: Vec<u8>,
}

impl Buffer {
    /// Appends a view.
    pub(super) fn view(&mut self, root: &mut Root, bytes: &[u8], target: Option<Target>) -> Index<View> {
        let offset = self.bytes.len();
        if bytes.len() > LARGE {
            // no more than it takes: doubled, a stand's instances would be held twice
            self.bytes.reserve_exact(bytes.len() + 4);
        }
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        root.push(View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(offset)),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: Default::default(),
        })
    }

    /// Appends rows of floats, one row an element. `target` is `None` for data that is not a vertex attribute.
    pub(super) fn floats<const N: usize>(
        &mut self,
        root: &mut Root,
        rows: &[[f32; N]],
        target: Option<Target>,
    ) -> Index<Accessor> {
        let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(root, &bytes, target);
        let kind = [Type::Scalar, Type::Vec2, Type::Vec3, Type::Vec4][N - 1];
        root.push(accessor(view, rows.len(), ComponentType::F32, kind))
    }

    /// Appends positions, with the smallest and largest of each axis as the specification demands.
    pub(super) fn positions(&mut self, root: &mut Root, rows: &[[f32; 3]]) -> Index<Accessor> {
        let index = self.floats(root, rows, Some(Target::ArrayBuffer));
        let extreme = |pick: fn(f32, f32) -> f32, start: f32| {
            let corner = rows.iter().fold([start; 3], |c, row| [0, 1, 2].map(|axis| pick(c[axis], row[axis])));
            Some(Value::from(corner.map(f64::from).to_vec()))
        };
        let accessor = &mut root.accessors[index.value()];
        accessor.min = extreme(f32::min, f32::INFINITY);
        accessor.max = extreme(f32::max, f32::NEG_INFINITY);
        index
    }

    /// Appends vertex numbers, in 16 bits where `vertices` allows (65535 itself restarts primitives and must not occur).
    pub(super) fn indices(&mut self, root: &mut Root, triangles: &[[u32; 3]], vertices: usize) -> Index<Accessor> {
        let numbers = triangles.as_flattened();
        let short = vertices <= 65_535;
        let bytes: Vec<u8> = if short {
            numbers.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect()
        } else {
            numbers.iter().flat_map(|i| i.to_le_bytes()).collect()
        };
        let view = self.view(root, &bytes, Some(Target::ElementArrayBuffer));
        let component = if short { ComponentType::U16 } else { ComponentType::U32 };
        root.push(accessor(view, numbers.len(), component, Type::Scalar))
    }
}

fn accessor(view: Index<View>, count: usize, component: ComponentType, kind: Type) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64::from(count),
        component_type: Valid(GenericComponentType(component)),
        extensions: None,
        extras: Default::default(),
        type_: Valid(kind),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}
