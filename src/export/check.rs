//! What must hold of a frame before any of it is written. JSON would turn a NaN into null and a reader would find the
//! broken reference, so faults are found here.

use super::placement::Placement;
use super::png::check_size;
use super::{ExportError, Layout};
use crate::frame::{Frame, Material, Model};

/// Checks references, sizes and numbers of everything that is in use, and gives the place of each instance.
pub(super) fn check(frame: &Frame) -> Result<Vec<Placement>, ExportError> {
    let mut placements = Vec::with_capacity(frame.instances.len());
    let mut used = vec![false; frame.models.len()];
    for (number, instance) in frame.instances.iter().enumerate() {
        *used.get_mut(instance.model as usize).ok_or_else(|| ExportError::Missing {
            what: format!("instance {number}"),
            kind: "model",
            number: instance.model,
        })? = true;
        let not_similar = |residual| ExportError::NotSimilar { instance: number, residual };
        placements.push(Placement::of(&instance.transform).map_err(not_similar)?);
    }
    frame.models.iter().zip(&used).filter(|(_, used)| **used).try_for_each(|(model, _)| check_model(frame, model))?;
    Ok(placements)
}

fn check_model(frame: &Frame, model: &Model) -> Result<(), ExportError> {
    for part in &model.parts {
        let missing = |kind, number| ExportError::Missing { what: format!("model {:?}", model.name), kind, number };
        let mesh = frame.meshes.get(part.mesh as usize).ok_or_else(|| missing("mesh", part.mesh))?;
        mesh.check().map_err(|fault| ExportError::Mesh { mesh: part.mesh as usize, fault })?;
        let material = frame.materials.get(part.material as usize).ok_or_else(|| missing("material", part.material))?;
        check_material(frame, material)?;
    }
    Ok(())
}

fn check_material(frame: &Frame, material: &Material) -> Result<(), ExportError> {
    let what = || format!("material {:?}", material.name);
    let numbers = material.colour.iter().chain(&material.transmission).chain([&material.roughness]);
    if numbers.into_iter().any(|x| !x.is_finite()) {
        return Err(ExportError::NotFinite { what: what() });
    }
    for number in [material.reflected, material.transmitted, material.relief].into_iter().flatten() {
        let missing = || ExportError::Missing { what: what(), kind: "texture", number };
        let texture = frame.textures.get(number as usize).ok_or_else(missing)?;
        check_size(&format!("texture {:?}", texture.name), texture.width, texture.height, texture.pixels.len())?;
    }
    Ok(())
}

/// Refuses a frame whose geometry alone cannot fit into a GLB, before memory is taken for it.
pub(super) fn check_bytes(frame: &Frame, layout: Layout) -> Result<(), ExportError> {
    let part_bytes = |mesh: u32| {
        let mesh = &frame.meshes[mesh as usize];
        mesh.positions.len() as u64 * 32 + mesh.triangles.len() as u64 * 6
    };
    let model_bytes = |model: u32| frame.models[model as usize].parts.iter().map(|p| part_bytes(p.mesh)).sum::<u64>();
    let instances = frame.instances.iter();
    let bytes = match layout {
        Layout::Merged => instances.map(|i| model_bytes(i.model)).fold(0, u64::saturating_add),
        // A node takes at least this much JSON; an instance three attributes.
        Layout::Nodes => frame.instances.len() as u64 * 60,
        Layout::Instanced => frame.instances.len() as u64 * 40,
    };
    if bytes > u64::from(u32::MAX) { Err(ExportError::TooLarge { bytes }) } else { Ok(()) }
}
