//! The GLB files of a whole scene in all three layouts, read back by an independent reader: every leaf that hangs is
//! there once, under its name, and nothing that no leaf wears.

mod common;

use common::{render, small};
use gltf::{Gltf, Node};
use leafseason::run::{self, Options};
use std::collections::BTreeSet;
use std::fs;

/// What a run says of one frame, to hold the file against.
struct Said {
    file: Vec<u8>,
    /// Ids of the leaves that hang, as the file of states writes them.
    hanging: BTreeSet<String>,
    /// Names of the models that leaves wear.
    models: BTreeSet<String>,
}

/// Renders the small scene, in which some leaves have fallen and are not seen, to a GLB file of the layout.
fn said(layout: &str) -> Said {
    let scene = small(&["time.day=10", "fall.on=false", "output.png=false", &format!("output.gltf={layout}")]);
    let folder = tempfile::tempdir().unwrap();
    let states = folder.path().join("states.csv");
    let options = Options { out: folder.path().to_owned(), states: Some(states.clone()), ..Options::default() };
    let frame = render(&scene, &options).report.frames.remove(0);
    let text = fs::read_to_string(states).unwrap();
    let fields = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let hanging = fields.filter(|fields| fields[3] != "fallen").map(|fields| fields[2].to_owned());
    let hanging: BTreeSet<String> = hanging.collect();
    assert!(frame.fallen > 0 && frame.fallen < frame.leaves);
    assert_eq!(hanging.len() as u64, frame.leaves - frame.fallen);
    let plan = run::plan(&scene, &Options::default()).unwrap();
    let names: Vec<&String> = scene.species[0].season.states.keys().collect();
    let model = |garment: &leafseason::compose::Garment| {
        format!("leaf_{}_{}", names[usize::from(garment.state)].replace('-', "_"), garment.variant)
    };
    let models = plan.garments.iter().map(model).collect();
    Said { file: fs::read(folder.path().join("small.glb")).unwrap(), hanging, models }
}

fn triangles(node: &Node<'_>) -> usize {
    node.mesh().map_or(0, |mesh| mesh.primitives().map(|part| part.indices().unwrap().count() / 3).sum())
}

/// The names of the meshes but that of the wood; a model has up to three, one for each length of its petiole.
fn leaf_meshes(gltf: &Gltf) -> BTreeSet<String> {
    let names = gltf.meshes().map(|mesh| mesh.name().unwrap().to_owned()).filter(|name| name != "trunk");
    let model = |name: String| name.trim_end_matches("_short").trim_end_matches("_long").to_owned();
    names.map(model).collect()
}

#[test]
fn a_node_stands_for_every_leaf_that_hangs_and_a_mesh_for_every_model_worn() {
    let said = said("nodes");
    let gltf = Gltf::from_slice(&said.file).unwrap();
    let names: Vec<&str> = gltf.nodes().filter_map(|node| node.name()?.strip_prefix("leaf_")).collect();
    assert_eq!(names.len(), said.hanging.len());
    assert_eq!(names.iter().map(|&name| name.to_owned()).collect::<BTreeSet<_>>(), said.hanging);
    assert_eq!(leaf_meshes(&gltf), said.models);
    assert!((said.models.len() + 1..=3 * said.models.len() + 1).contains(&gltf.meshes().count()));
    let used: BTreeSet<usize> = gltf.nodes().filter_map(|node| Some(node.mesh()?.index())).collect();
    assert_eq!(used.len(), gltf.meshes().count());
    // A material for each model's blade, the petiole's, and one for each girth of the wood.
    let girths = gltf.meshes().find(|mesh| mesh.name() == Some("trunk")).unwrap().primitives().count();
    assert!(gltf.materials().count() <= said.models.len() + 1 + girths);
    // The blade of a model is stored once, whatever its petioles.
    let blade = |mesh: gltf::Mesh<'_>| {
        let model = mesh.name()?.trim_end_matches("_short").trim_end_matches("_long").to_owned();
        let positions = mesh.primitives().next()?.get(&gltf::Semantic::Positions)?.index();
        (model != "trunk").then_some((model, positions))
    };
    assert_eq!(gltf.meshes().filter_map(blade).collect::<BTreeSet<_>>().len(), said.models.len());
    let root = gltf.default_scene().unwrap().nodes().next().unwrap();
    assert_eq!((root.name(), root.children().count()), (Some("tree"), said.hanging.len() + 1));
}

#[test]
fn merged_leaves_are_as_many_triangles_as_the_leaves_have() {
    let (merged, nodes) = (said("merged"), said("nodes"));
    let (gltf, apart) = (Gltf::from_slice(&merged.file).unwrap(), Gltf::from_slice(&nodes.file).unwrap());
    let found: Vec<(&str, usize)> = gltf
        .nodes()
        .filter(|node| node.mesh().is_some())
        .map(|node| (node.mesh().unwrap().name().unwrap(), triangles(&node)))
        .collect::<Vec<_>>();
    let of = |leaf: bool| {
        let is_leaf = |node: &Node<'_>| node.name().is_some_and(|name| name.starts_with("leaf_"));
        apart.nodes().filter(|node| is_leaf(node) == leaf).map(|node| triangles(&node)).sum::<usize>()
    };
    assert_eq!(found, [("wood", of(false)), ("leaves", of(true))]);
}

#[test]
fn instances_are_as_many_as_the_leaves_and_each_model_stands_once() {
    let said = said("instanced");
    // The reader refuses a required extension that it does not know.
    let gltf = Gltf::from_slice_without_validation(&said.file).unwrap();
    let json = serde_json::to_value(gltf.document.clone().into_json()).unwrap();
    let mut count = 0;
    for node in gltf.nodes().filter(|node| node.mesh().is_some_and(|mesh| mesh.name() != Some("trunk"))) {
        let attributes = &json["nodes"][node.index()]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        let counts = ["TRANSLATION", "ROTATION", "SCALE"]
            .map(|name| attributes[name].as_u64().map_or(1, |n| gltf.accessors().nth(n as usize).unwrap().count()));
        assert!(counts.iter().all(|&other| other == counts[0]), "{counts:?}");
        count += counts[0];
    }
    assert_eq!(count, said.hanging.len());
    assert_eq!(leaf_meshes(&gltf), said.models);
}
