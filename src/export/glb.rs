//! A frame as a GLB file: one scene, one root node that moves nothing, metres, +Y up.

use super::ExportError;
use super::check::{check, check_bytes};
use super::document::Document;
use crate::base::figures::Figures;
use crate::frame::Frame;
use gltf_json::validation::USize64;
use gltf_json::{Asset, Buffer, Root, Scene};

/// How instances are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layout {
    /// One node a leaf, sharing the meshes: core glTF, keeps every leaf's identity, many draw calls.
    Nodes,
    /// Leaves baked into one mesh with a primitive for each material: core glTF, few draw calls, the largest file. The
    /// only layout that every reader shows and counts rightly.
    Merged,
    /// One node a model with `EXT_mesh_gpu_instancing`, required: the smallest file, for readers that know it.
    Instanced,
}

/// Writes a frame. Only what its instances use is written; the ground, camera and lights are not part of the asset.
///
/// The figures count nodes, meshes, materials, textures and bytes of the file and the triangles that a viewer draws;
/// `items` is the number of instances.
///
/// # Errors
/// [`ExportError`] when the frame breaks its contract or the file would pass 4 GiB.
pub fn glb(frame: &Frame, layout: Layout) -> Result<(Vec<u8>, Figures), ExportError> {
    let placements = check(frame)?;
    check_bytes(frame, layout)?;
    let mut document = Document::new(frame);
    let root_node = document.node("tree", None);
    let children = document.children(layout, &placements)?;
    document.root.nodes[root_node.value()].children = (!children.is_empty()).then_some(children);
    let triangles = document.triangles;
    let (root, bytes) = finished(document, root_node);
    let file = container(&root, bytes)?;
    let figures = Figures::of(frame.instances.len() as u64)
        .with("nodes", root.nodes.len())
        .with("meshes", root.meshes.len())
        .with("materials", root.materials.len())
        .with("textures", root.textures.len())
        .with("triangles", triangles)
        .with("bytes", file.len());
    Ok((file, figures))
}

fn finished(document: Document<'_>, root_node: gltf_json::Index<gltf_json::Node>) -> (Root, Vec<u8>) {
    let Document { mut root, buffer, extensions, .. } = document;
    root.asset =
        Asset { generator: Some(concat!("leafseason ", env!("CARGO_PKG_VERSION")).to_owned()), ..Asset::default() };
    root.extensions_used = extensions.into_iter().map(str::to_owned).collect();
    let (extensions, extras) = (None, Default::default());
    let scene = root.push(Scene { extensions, extras, name: Some("scene".to_owned()), nodes: vec![root_node] });
    root.scene = Some(scene);
    if !buffer.bytes.is_empty() {
        let byte_length = USize64::from(buffer.bytes.len());
        let (extensions, extras) = (None, Default::default());
        root.push(Buffer { byte_length, name: None, uri: None, extensions, extras });
    }
    (root, buffer.bytes)
}

/// The GLB container (glTF 2.0, section 4.4): a header and two chunks, each padded to four bytes. The binary one is not held
/// twice.
fn container(root: &Root, binary: Vec<u8>) -> Result<Vec<u8>, ExportError> {
    let mut json = serde_json::to_vec(root)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk_of_binary = if binary.is_empty() { 0 } else { 8 + binary.len() as u64 };
    let total = 12 + 8 + json.len() as u64 + chunk_of_binary;
    let length = u32::try_from(total).map_err(|_| ExportError::TooLarge { bytes: total })?;
    // Other lengths fit, since the whole does.
    let header = |kind: &[u8; 4], content: &[u8]| [(content.len() as u32).to_le_bytes(), *kind].concat();
    let mut head = [*b"glTF", 2u32.to_le_bytes(), length.to_le_bytes()].concat();
    head.extend(header(b"JSON", &json));
    head.append(&mut json);
    if !binary.is_empty() {
        head.extend(header(b"BIN\0", &binary));
    }
    let mut file = binary;
    file.reserve_exact(head.len());
    file.splice(0..0, head);
    Ok(file)
}
