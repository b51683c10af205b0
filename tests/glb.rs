//! A hand-made frame in all three layouts, read back by an independent reader.

use gltf::Gltf;
use leafseason::base::mesh::Mesh;
use leafseason::base::vector::{Affine, DVec3, Mat3, Vec2, Vec3, rotated};
use leafseason::export::{ExportError, Layout, glb};
use leafseason::frame::{
    Background, Camera, Frame, Ground, GroundPart, Instance, Material, Model, Part, Sky, Sun, Texture, ToneMap,
    UNBALANCED, View,
};
use std::sync::Arc;

const LAYOUTS: [Layout; 3] = [Layout::Nodes, Layout::Merged, Layout::Instanced];
const LEAVES: usize = 19;

fn quad(width: f32, height: f32) -> Mesh {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let mut mesh = Mesh {
        positions: corners
            .iter()
            .map(|&(x, y)| Vec3::new((x - 0.5) * width, y * height, x * y * 0.1 * width))
            .collect(),
        normals: Vec::new(),
        uvs: corners.iter().map(|&(x, y)| Vec2::new(x, 1.0 - y)).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    mesh.recompute_normals();
    mesh
}

fn texture(name: &str, repeat: bool, shift: u8) -> Texture {
    let pixels = (0..64u8).map(|i| [i.wrapping_mul(3).wrapping_add(shift), 128, i]).collect();
    Texture { name: name.to_owned(), width: 8, height: 8, pixels: Arc::new(pixels), repeat }
}

fn material(name: &str, reflected: u32, transmitted: Option<u32>, transmission: [f32; 3]) -> Material {
    Material {
        name: name.to_owned(),
        colour: [1.0, 0.9, 0.8],
        reflected: Some(reflected),
        transmission,
        transmitted,
        back_gain: 1.0,
        behind: None,
        relief: None,
        gloss: 0.04,
        roughness: 0.6,
        two_sided: transmitted.is_some(),
        unlit: false,
        ground: GroundPart::None,
    }
}

fn place(number: usize) -> Affine {
    let axis = DVec3::new(1.0, number as f64 * 0.3, 0.5).normalize();
    let scale = 0.5 + 0.05 * number as f64;
    let column = |unit| (rotated(unit, axis, number as f64) * scale).map(|x| x as f32);
    let linear = Mat3::from_columns(&[column(DVec3::x()), column(DVec3::y()), column(DVec3::z())]);
    Affine { linear, translation: Vec3::new(number as f32 * 0.1, 2.0, -0.3) }
}

fn model(name: &str, parts: &[(u32, u32)]) -> Model {
    let parts = parts.iter().map(|&(mesh, material)| Part { mesh, material }).collect();
    Model { name: name.to_owned(), parts }
}

/// A trunk and 19 leaves of two models, one of them with a petiole; and a mesh, a texture, a material and a model that
/// nothing uses.
fn frame() -> Frame {
    let trunk = Instance { model: 0, transform: Affine::identity(), leaf: None };
    let leaf = |i: usize| Instance { model: 1 + (i % 2) as u32, transform: place(i + 1), leaf: Some(7_000 + i as u64) };
    Frame {
        meshes: [quad(0.3, 4.0), quad(0.1, 0.12), quad(0.004, 0.05), quad(9.0, 9.0)].map(Arc::new).into(),
        textures: [
            texture("bark", true, 9),
            texture("leaf_red", false, 70),
            texture("through", false, 3),
            texture("ground", true, 0),
        ]
        .map(Arc::new)
        .into(),
        materials: vec![
            material("bark", 0, None, [0.0; 3]),
            material("leaf_red", 1, Some(2), [0.5, 0.25, 0.1]),
            material("unused", 3, None, [0.0; 3]),
        ],
        models: vec![
            model("trunk", &[(0, 0)]),
            model("leaf_red_0", &[(1, 1)]),
            model("leaf_red_1", &[(1, 1), (2, 0)]),
            model("unused", &[(3, 2)]),
        ],
        instances: std::iter::once(trunk).chain((0..LEAVES).map(leaf)).collect(),
        fallen: 0,
        camera: Camera {
            position: Vec3::new(0.0, 2.0, 9.0),
            target: Vec3::new(0.0, 2.0, 0.0),
            field_of_view: 0.7,
            near: 0.05,
            far: 100.0,
        },
        sun: Sun { direction: Vec3::y(), irradiance: [1.0; 3] },
        sky: Sky { zenith: [0.2; 3], horizon: [0.5; 3], ..Sky::default() },
        ground: Some(Ground { texture: 3, tile: 1.0, haze: 50.0, ..Ground::default() }),
        background: Background::Sky,
        view: View {
            width: 8,
            height: 8,
            samples: 1,
            lod_error: 0.3,
            shadow_size: 0,
            exposure: 1.0,
            metered: false,
            balance: UNBALANCED,
            tone_map: ToneMap::None,
            wireframe: None,
        },
    }
}

fn read(file: &[u8], layout: Layout) -> Gltf {
    match layout {
        // The reader refuses a required extension that it does not know.
        Layout::Instanced => Gltf::from_slice_without_validation(file).unwrap(),
        _ => Gltf::from_slice(file).unwrap(),
    }
}

/// Every corner of every triangle in world space, sorted, rounded to a tenth of a millimetre.
fn corners(gltf: &Gltf) -> Vec<[i64; 3]> {
    let blob = gltf.blob.as_deref().unwrap();
    let mut found = Vec::new();
    for node in gltf.nodes().filter(|node| node.mesh().is_some()) {
        for place in places(&node, gltf) {
            for primitive in node.mesh().unwrap().primitives() {
                let reader = primitive.reader(|_| Some(blob));
                let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
                let indices = reader.read_indices().unwrap().into_u32();
                found.extend(indices.map(|i| rounded(place.point(positions[i as usize].into()))));
            }
        }
    }
    found.sort_unstable();
    found
}

fn rounded(point: Vec3) -> [i64; 3] {
    [0, 1, 2].map(|axis: usize| (f64::from(point[axis]) * 1e4).round() as i64)
}

fn places(node: &gltf::Node<'_>, gltf: &Gltf) -> Vec<Affine> {
    let rows = |number: u64, width: usize| -> Vec<f32> {
        let accessor = gltf.accessors().nth(number as usize).unwrap();
        let bytes = &gltf.blob.as_ref().unwrap()[accessor.view().unwrap().offset()..][..accessor.count() * width * 4];
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    };
    let json = serde_json::to_value(gltf.document.clone().into_json()).unwrap();
    let extension = &json["nodes"][node.index()]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    let Some(translations) = extension["TRANSLATION"].as_u64() else {
        let (translation, rotation, scale) = node.transform().decomposed();
        return vec![affine(translation, rotation, scale[0])];
    };
    let (t, r) = (rows(translations, 3), rows(extension["ROTATION"].as_u64().unwrap(), 4));
    let s = rows(extension["SCALE"].as_u64().unwrap(), 3);
    let one = |i: usize| affine(t[i * 3..][..3].try_into().unwrap(), r[i * 4..][..4].try_into().unwrap(), s[i * 3]);
    (0..t.len() / 3).map(one).collect()
}

fn affine(translation: [f32; 3], rotation: [f32; 4], scale: f32) -> Affine {
    let placement = leafseason::export::Placement { translation, rotation, scale };
    Affine { linear: placement.linear().map(|x| x as f32), translation: translation.into() }
}

#[test]
fn all_layouts_show_the_same_triangles() {
    let frame = frame();
    let mut expected: Vec<[i64; 3]> = Vec::new();
    for instance in &frame.instances {
        for part in &frame.models[instance.model as usize].parts {
            let mesh = &frame.meshes[part.mesh as usize];
            let all = mesh.triangles.as_flattened().iter();
            expected.extend(all.map(|&v| rounded(instance.transform.point(mesh.positions[v as usize]))));
        }
    }
    expected.sort_unstable();
    for layout in LAYOUTS {
        let (file, figures) = glb(&frame, layout).unwrap();
        let found = corners(&read(&file, layout));
        assert_eq!(found.len(), expected.len(), "{layout:?}");
        assert_eq!(figures.values["triangles"], expected.len() / 3);
        assert_eq!(figures.values["bytes"], file.len());
        // Rounding to the grid may fall either way, so sorted lists are compared as bags with one step of play.
        let far = |p: &[i64; 3]| !found.iter().any(|q| p.iter().zip(q).all(|(a, b)| (a - b).abs() <= 1));
        assert!(!expected.iter().any(far), "{layout:?}");
    }
}

#[test]
fn the_structure_is_that_of_the_layout() {
    for (layout, nodes, meshes) in [(Layout::Nodes, 21, 3), (Layout::Merged, 3, 2), (Layout::Instanced, 4, 3)] {
        let gltf = read(&glb(&frame(), layout).unwrap().0, layout);
        assert_eq!((gltf.nodes().count(), gltf.meshes().count()), (nodes, meshes), "{layout:?}");
        assert_eq!((gltf.scenes().count(), gltf.default_scene().unwrap().nodes().count()), (1, 1));
        let root = gltf.default_scene().unwrap().nodes().next().unwrap();
        assert_eq!(root.transform().matrix(), IDENTITY);
        assert_eq!(root.children().count(), nodes - 1);
        assert_eq!((gltf.cameras().count(), gltf.materials().count(), gltf.images().count()), (0, 2, 3));
        let required: Vec<&str> = gltf.extensions_required().collect();
        assert_eq!(required.is_empty(), layout != Layout::Instanced, "{required:?}");
        let mut names: Vec<&str> = gltf.nodes().map(|node| node.name().unwrap()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), nodes);
        assert_eq!(names.contains(&"leaf_0000000000001b6a"), layout == Layout::Nodes);
    }
}

const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

#[test]
fn materials_and_textures_come_back() {
    let (frame, (file, _)) = (frame(), glb(&frame(), Layout::Merged).unwrap());
    let (document, _, images) = gltf::import_slice(&file).unwrap();
    let leaf = document.materials().find(|m| m.name() == Some("leaf_red")).unwrap();
    assert!(leaf.double_sided() && leaf.alpha_mode() == gltf::material::AlphaMode::Opaque);
    let surface = leaf.pbr_metallic_roughness();
    assert_eq!((surface.metallic_factor(), surface.roughness_factor()), (0.0, 0.6));
    assert_eq!(surface.base_color_factor(), [1.0, 0.9, 0.8, 1.0]);
    let texture = surface.base_color_texture().unwrap().texture();
    assert_eq!(images[texture.source().index()].pixels, frame.textures[1].pixels.as_flattened());
    assert_eq!(texture.sampler().wrap_s(), gltf::texture::WrappingMode::ClampToEdge);
}

#[test]
fn relief_is_the_normal_texture_and_is_written_as_it_is() {
    let mut frame = frame();
    for material in &mut frame.materials {
        material.relief = Some(3);
    }
    let (file, _) = glb(&frame, Layout::Merged).unwrap();
    let (document, _, images) = gltf::import_slice(&file).unwrap();
    let normals: Vec<_> = document.materials().map(|material| material.normal_texture().expect("normals")).collect();
    assert!(normals.len() > 1 && normals.iter().all(|normal| normal.scale() == 1.0 && normal.tex_coord() == 0));
    let sources: Vec<usize> = normals.iter().map(|normal| normal.texture().source().index()).collect();
    assert!(sources.iter().all(|&source| source == sources[0]), "one picture for all: {sources:?}");
    assert_eq!(images[sources[0]].pixels, frame.textures[3].pixels.as_flattened());
    frame.materials[0].relief = Some(99);
    assert!(glb(&frame, Layout::Merged).is_err());
}

#[test]
fn share_times_tint_is_the_transmittance() {
    let frame = frame();
    let (file, _) = glb(&frame, Layout::Merged).unwrap();
    let (document, _, images) = gltf::import_slice(&file).unwrap();
    let json = serde_json::to_value(document.into_json()).unwrap();
    let leaf = json["materials"].as_array().unwrap().iter().find(|m| m["name"] == "leaf_red").unwrap();
    let extension = &leaf["extensions"]["KHR_materials_diffuse_transmission"];
    let share = extension["diffuseTransmissionFactor"].as_f64().unwrap() as f32;
    let texture = extension["diffuseTransmissionColorTexture"]["index"].as_u64().unwrap() as usize;
    let pixels = &images[json["textures"][texture]["source"].as_u64().unwrap() as usize].pixels;
    let linear = |code: u8| leafseason::base::maths::srgb_to_linear(f32::from(code) / 255.0);
    let mut most = 0.0f32;
    for (texel, written) in frame.textures[2].pixels.iter().zip(pixels.chunks_exact(3)) {
        for channel in 0..3 {
            let wanted = linear(texel[channel]) * frame.materials[1].transmission[channel];
            most = most.max(wanted);
            // Half a step of 8-bit sRGB is at most 0.0045 of full light.
            assert!((share * linear(written[channel]) - wanted).abs() < 0.0045 * share + 1e-6);
        }
    }
    assert!((share - most).abs() < 1e-6);
}

#[test]
fn the_same_frame_gives_the_same_bytes() {
    for layout in LAYOUTS {
        assert_eq!(glb(&frame(), layout).unwrap().0, glb(&frame(), layout).unwrap().0);
    }
}

#[test]
fn large_meshes_take_wide_indices_and_small_ones_narrow() {
    let mut frame = frame();
    let positions = (0..70_000).map(|i| Vec3::new(i as f32, 0.0, (i % 3) as f32)).collect::<Vec<_>>();
    *Arc::make_mut(&mut frame.meshes[0]) = Mesh {
        normals: vec![Vec3::y(); positions.len()],
        uvs: vec![Vec2::zeros(); positions.len()],
        triangles: vec![[0, 1, 69_999]],
        positions,
    };
    let gltf = read(&glb(&frame, Layout::Nodes).unwrap().0, Layout::Nodes);
    let kinds =
        gltf.meshes().flat_map(|mesh| mesh.primitives().map(|p| p.indices().unwrap().data_type()).collect::<Vec<_>>());
    let wide = kinds.clone().filter(|kind| *kind == gltf::accessor::DataType::U32).count();
    assert_eq!((wide, kinds.count()), (1, 4));
}

#[test]
fn broken_frames_are_refused_and_nothing_is_written() {
    type Break = fn(&mut Frame);
    type IsWanted = fn(&ExportError) -> bool;
    let table: [(Break, IsWanted); 8] = [
        (|f| f.instances[3].model = 9, |e| matches!(e, ExportError::Missing { kind: "model", number: 9, .. })),
        (|f| f.models[1].parts[0].mesh = 9, |e| matches!(e, ExportError::Missing { kind: "mesh", .. })),
        (|f| f.models[1].parts[0].material = 9, |e| matches!(e, ExportError::Missing { kind: "material", .. })),
        (|f| f.materials[1].transmitted = Some(9), |e| matches!(e, ExportError::Missing { kind: "texture", .. })),
        (
            |f| Arc::make_mut(&mut f.meshes[1]).positions[0].x = f32::NAN,
            |e| matches!(e, ExportError::Mesh { mesh: 1, .. }),
        ),
        (|f| f.materials[0].roughness = f32::INFINITY, |e| matches!(e, ExportError::NotFinite { .. })),
        (|f| f.instances[2].transform.linear *= -1.0, |e| matches!(e, ExportError::NotSimilar { instance: 2, .. })),
        (
            |f| Arc::make_mut(&mut Arc::make_mut(&mut f.textures[0]).pixels).truncate(63),
            |e| matches!(e, ExportError::Size { .. }),
        ),
    ];
    for (break_it, is_wanted) in table {
        for layout in LAYOUTS {
            let mut frame = frame();
            break_it(&mut frame);
            let error = glb(&frame, layout).unwrap_err();
            assert!(is_wanted(&error), "{error}");
        }
    }
}

#[test]
fn an_empty_frame_is_an_empty_tree() {
    let mut frame = frame();
    frame.instances.clear();
    for layout in LAYOUTS {
        let (file, figures) = glb(&frame, layout).unwrap();
        let gltf = Gltf::from_slice(&file).unwrap();
        assert_eq!((gltf.nodes().count(), gltf.buffers().count(), figures.items), (1, 0, 0));
    }
}

/// Writes the files for other validators when `LEAFSEASON_GLB_OUT` names a folder.
#[test]
fn files_for_other_readers() {
    let Some(folder) = std::env::var_os("LEAFSEASON_GLB_OUT") else { return };
    for layout in LAYOUTS {
        let path = std::path::Path::new(&folder).join(format!("{layout:?}.glb").to_lowercase());
        std::fs::write(path, glb(&frame(), layout).unwrap().0).unwrap();
    }
}
