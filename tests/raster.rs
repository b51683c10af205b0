//! The rasteriser against closed forms: what a flat leaf must send to the eye under light that is known.

use leafseason::base::mesh::Mesh;
use leafseason::base::vector::{Affine, Vec2, Vec3};
use leafseason::frame::{
    Background, Camera, Frame, Instance, Material, Model, Part, Sky, Sun, Texture, ToneMap, UNBALANCED, View, Wireframe,
};
use leafseason::raster;
use std::f32::consts::PI;
use std::sync::Arc;

const WIDTH: u32 = 96;
const HEIGHT: u32 = 64;

/// A square of two metres in the plane z = 0 that faces +z.
fn square() -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Mesh {
        positions: corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect(),
        normals: vec![Vec3::z(); 4],
        uvs: corners.iter().map(|&(x, y)| Vec2::new(x * 0.5 + 0.5, 0.5 - y * 0.5)).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// A sun that has risen, so that none of its disc is cut off.
fn above(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, 0.006, direction.z).normalize()
}

fn leaf() -> Material {
    let (transmission, roughness) = ([0.1, 0.3, 0.05], 0.5);
    Material { transmission, roughness, two_sided: true, ..Material::matte("leaf", [0.2, 0.4, 0.1]) }
}

/// A leaf before the camera, without light.
fn frame() -> Frame {
    Frame {
        meshes: vec![square().into()],
        textures: Vec::new(),
        materials: vec![leaf()],
        models: vec![Model { name: "leaf".into(), parts: vec![Part { mesh: 0, material: 0 }] }],
        instances: vec![Instance { model: 0, transform: Affine::identity(), leaf: None }],
        fallen: 0,
        camera: Camera {
            position: Vec3::new(0.0, 0.0, 4.0),
            target: Vec3::zeros(),
            field_of_view: 2.0 * libm::atanf(0.5),
            near: 0.05,
            far: 100.0,
        },
        sun: Sun { direction: above(Vec3::z()), irradiance: [0.0; 3] },
        sky: Sky { zenith: [0.0; 3], horizon: [0.0; 3], ..Sky::default() },
        ground: None,
        background: Background::Sky,
        view: View {
            width: WIDTH,
            height: HEIGHT,
            samples: 8,
            lod_error: 0.3,
            shadow_size: 256,
            exposure: 1.0,
            metered: false,
            balance: UNBALANCED,
            tone_map: ToneMap::None,
            wireframe: None,
        },
    }
}

fn middle(frame: &Frame) -> [u8; 4] {
    raster::draw(frame).0.at(WIDTH / 2, HEIGHT / 2)
}

fn codes(linear: [f32; 3]) -> [u8; 3] {
    linear.map(leafseason::base::maths::linear_to_srgb8)
}

fn assert_near(got: [u8; 4], expected: [u8; 3]) {
    for k in 0..3 {
        assert!(got[k].abs_diff(expected[k]) <= 1, "{got:?} is not {expected:?}");
    }
}

#[test]
fn under_an_even_sky_a_leaf_shows_reflectance_plus_transmittance() {
    let mut frame = frame();
    frame.sky = Sky { zenith: [1.0; 3], horizon: [1.0; 3], ..Sky::default() };
    assert_near(middle(&frame), codes([0.3, 0.7, 0.15]));
    let corner = raster::draw(&frame).0.at(0, 0);
    assert_eq!(corner, [255; 4]);
}

#[test]
fn the_sun_before_a_leaf_shows_its_reflectance_and_behind_it_its_transmittance() {
    let mut frame = frame();
    frame.sun.irradiance = [PI; 3];
    assert_near(middle(&frame), codes([0.2, 0.4, 0.1]));
    frame.sun.direction = Vec3::new(0.0, 0.6, 0.8);
    assert_near(middle(&frame), codes([0.16, 0.32, 0.08]));
    frame.sun.direction = Vec3::new(0.0, 0.6, -0.8);
    assert_near(middle(&frame), codes([0.08, 0.24, 0.04]));
}

#[test]
fn a_leaf_lit_from_behind_outshines_its_neighbour_in_the_shade() {
    // A clear noon: the sky gives a quarter of the sun's light. A green leaf of the red maple.
    let mut frame = frame();
    frame.materials[0].colour = [0.045, 0.085, 0.030];
    frame.materials[0].transmission = [0.035, 0.085, 0.010];
    frame.sky = Sky { zenith: [0.25; 3], horizon: [0.25; 3], ..Sky::default() };
    frame.sun = Sun { direction: Vec3::new(0.0, 0.6, -0.8), irradiance: [PI; 3] };
    frame.view.exposure = 4.0;
    let behind = middle(&frame);
    frame.sun.direction = Vec3::new(0.0, 0.6, 0.8);
    let front = middle(&frame);
    // A board between the leaf and the sun, above what the middle of the picture shows.
    let board = Affine { translation: Vec3::new(0.0, 1.8, 2.4), ..Affine::identity() };
    frame.materials.push(Material { name: "board".into(), transmission: [0.0; 3], ..leaf() });
    frame.models.push(Model { name: "board".into(), parts: vec![Part { mesh: 0, material: 1 }] });
    frame.instances.push(Instance { model: 1, transform: board, leaf: None });
    let shaded = middle(&frame);
    let albedo: [f32; 3] = [0.045 + 0.035, 0.085 + 0.085, 0.030 + 0.010];
    assert_near(shaded, codes(albedo.map(|share| share * 0.25 * 4.0)));
    assert!((0..3).all(|k| behind[k] > shaded[k] && front[k] > shaded[k]), "{behind:?} {front:?} {shaded:?}");
}

#[test]
fn the_lower_side_reflects_by_its_own_measure() {
    let mut frame = frame();
    frame.materials[0].back_gain = 1.5;
    frame.sun = Sun { direction: above(-Vec3::z()), irradiance: [PI; 3] };
    frame.camera.position = Vec3::new(0.0, 0.0, -4.0);
    frame.view.shadow_size = 0;
    assert_near(middle(&frame), codes([0.3, 0.6, 0.15]));
}

/// A texture of one colour.
fn plain(name: &str, pixel: [u8; 3]) -> std::sync::Arc<Texture> {
    Texture { name: name.into(), width: 1, height: 1, pixels: Arc::new(vec![pixel]), repeat: false }.into()
}

#[test]
fn the_lower_side_wears_a_texture_of_its_own() {
    let mut frame = frame();
    frame.textures.push(plain("below", [188, 188, 188]));
    frame.materials[0].behind = Some(0);
    frame.sun.irradiance = [PI; 3];
    assert_near(middle(&frame), codes([0.2, 0.4, 0.1]));
    frame.sun.direction = above(-Vec3::z());
    frame.camera.position = Vec3::new(0.0, 0.0, -4.0);
    frame.view.shadow_size = 0;
    assert_near(middle(&frame), codes([0.2, 0.4, 0.1].map(|c| c * 0.5029)));
}

#[test]
fn relief_turns_the_surface_along_its_texture_on_both_sides() {
    let mut frame = frame();
    frame.view.shadow_size = 0;
    // Normals that lean by atan(4/3) to the right, which is +x here, or up.
    frame.textures.push(plain("right", [128 + 102, 128, 128 + 76]));
    frame.textures.push(plain("up", [128, 128 + 102, 128 + 76]));
    frame.sun.irradiance = [PI; 3];
    let mut seen = |relief: u32, sun: Vec3, eye: f32| {
        frame.materials[0].relief = Some(relief);
        frame.sun.direction = sun.normalize();
        frame.camera.position.z = eye;
        middle(&frame)
    };
    let lit = |share: f32| codes([0.2, 0.4, 0.1].map(|c| c * share));
    let across = Vec3::new(0.8, 0.006, 0.6);
    assert_near(seen(0, across, 4.0), lit(1.0));
    assert_near(seen(0, above(Vec3::z()), 4.0), lit(0.6));
    assert_near(seen(1, Vec3::new(0.0, 0.8, 0.6), 4.0), lit(1.0));
    // A slope that faces right above faces left below.
    assert_near(seen(0, -across + Vec3::y() * 0.012, -4.0), lit(1.0));
}

#[test]
fn something_between_sun_and_leaf_casts_its_shadow() {
    let mut frame = frame();
    frame.sun = Sun { direction: Vec3::new(0.0, 0.6, 0.8), irradiance: [PI; 3] };
    let mut board = frame.instances[0];
    // A board of 0.4 m on the way from the middle of the leaf to the sun, beside the camera's view of it.
    board.transform.linear *= 0.2;
    board.transform.translation = Vec3::new(0.0, 1.2, 1.6);
    frame.instances.push(board);
    assert_near(middle(&frame), [0; 3]);
    let beside = raster::draw(&frame).0.at(WIDTH / 2 + 12, HEIGHT / 2);
    assert_near(beside, codes([0.16, 0.32, 0.08]));
    frame.view.shadow_size = 0;
    assert_near(middle(&frame), codes([0.16, 0.32, 0.08]));
}

#[test]
fn a_square_covers_its_exact_share_of_the_picture() {
    let mut frame = frame();
    frame.sky = Sky { zenith: [0.0; 3], horizon: [0.0; 3], ..Sky::default() };
    frame.sun.irradiance = [PI / 0.2, PI / 0.4, PI / 0.1];
    frame.view.samples = 16;
    // Half a metre of height at 4 m is a quarter of the picture's 4 m.
    let turn = libm::sincosf(0.3);
    frame.instances[0].transform.linear =
        leafseason::base::vector::Mat3::new(turn.1, -turn.0, 0.0, turn.0, turn.1, 0.0, 0.0, 0.0, 1.0) * 0.613;
    let picture = raster::draw(&frame).0;
    let light = |pixel: &[u8; 4]| f64::from(leafseason::base::maths::srgb_to_linear(f32::from(pixel[0]) / 255.0));
    let covered: f64 = picture.pixels.iter().map(light).sum();
    let pixels_a_metre = f64::from(HEIGHT) / 4.0;
    let area = (2.0 * 0.613 * pixels_a_metre) * (2.0 * 0.613 * pixels_a_metre);
    assert!((covered / area - 1.0).abs() < 4e-3, "{covered} of {area}");
}

#[test]
fn a_wireframe_covers_its_exact_share_and_leaves_the_rest_as_it_is() {
    let mut frame = frame();
    frame.sky = Sky { zenith: [1.0; 3], horizon: [1.0; 3], ..Sky::default() };
    let plain = raster::draw(&frame).0;
    frame.view.wireframe = Some(Wireframe { width: 1.5, colour: [0.0; 3] });
    let lined = raster::draw(&frame).0;
    let changed = plain.pixels.iter().zip(&lined.pixels).filter(|(a, b)| a != b);
    // Lines are blended by square roots of light.
    let root = |code: u8| f64::from(leafseason::base::maths::srgb_to_linear(f32::from(code) / 255.0)).sqrt();
    let share: f64 = changed.map(|(a, b)| 1.0 - root(b[1]) / root(a[1])).sum();
    // Each triangle is covered but for one of the same shape within, half a line's width away from its sides: 32 pixels a leg.
    let leg = f64::from(HEIGHT) / 4.0 * 2.0;
    let inradius = leg * (1.0 - 0.5f64.sqrt());
    let open = 1.0 - 0.75 / inradius;
    let expected = leg * leg * (1.0 - open * open);
    assert!((share / expected - 1.0).abs() < 0.025, "{share} of {expected}");
    assert_eq!(lined.at(WIDTH / 2, HEIGHT / 2 - 1), [0, 0, 0, 255], "the diagonal passes through the middle");
    assert_eq!(lined.at(WIDTH / 2 + 8, HEIGHT / 2 + 2), plain.at(WIDTH / 2 + 8, HEIGHT / 2 + 2));
}

#[test]
fn an_unlit_surface_shows_its_colour_in_any_light() {
    let mut frame = frame();
    frame.materials[0].unlit = true;
    for (light, exposure) in [(0.0, 1.0), (7.0, 0.25), (0.1, 40.0)] {
        frame.sky = Sky { zenith: [light; 3], horizon: [light; 3], ..Sky::default() };
        frame.view.exposure = exposure;
        assert_near(middle(&frame), codes([0.2, 0.4, 0.1]));
    }
}

#[test]
fn what_is_behind_the_eye_or_cut_by_it_is_drawn_without_harm() {
    let mut frame = frame();
    frame.sky = Sky { zenith: [1.0; 3], horizon: [1.0; 3], ..Sky::default() };
    frame.camera.position = Vec3::new(0.0, 0.0, 0.01);
    frame.camera.target = Vec3::new(0.0, 1.0, 0.01);
    let picture = raster::draw(&frame).0;
    assert_eq!(picture.pixels.len(), (WIDTH * HEIGHT) as usize);
    assert!(picture.pixels.iter().any(|&p| p[0] < 255), "the leaf cut by the near plane is seen");
    frame.camera.target = Vec3::new(0.0, 0.0, 5.0);
    assert!(raster::draw(&frame).0.pixels.iter().all(|&p| p == [255; 4]));
}

#[test]
fn any_number_of_threads_draws_the_same_picture() {
    let mut frame = frame();
    frame.sky = Sky { zenith: [0.3, 0.5, 0.9], horizon: [0.8; 3], ..Sky::default() };
    frame.sun = Sun { direction: Vec3::new(0.36, 0.48, 0.8), irradiance: [2.0; 3] };
    for step in 0..300u64 {
        let place = |k| leafseason::base::random::hash_unit(step, k) * 3.0 - 1.5;
        let mut leaf = frame.instances[0];
        leaf.leaf = Some(step);
        leaf.transform.linear *= 0.1;
        leaf.transform.translation = Vec3::new(place(1), place(2), place(3));
        frame.instances.push(leaf);
    }
    let draw = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| raster::draw(&frame).0)
    };
    let one = draw(1);
    assert_eq!(one, draw(2));
    assert_eq!(one, draw(5));
}

#[test]
fn shadows_are_the_same_when_so_much_lies_about_that_the_map_is_drawn_in_strips() {
    // Leaves one before another in the sun, seen aslant; a quarter of a million others lie where nobody sees them.
    let mut few = frame();
    few.sun = Sun { direction: Vec3::new(0.1, 0.8, 0.6).normalize(), irradiance: [3.0; 3] };
    few.view.shadow_size = 2048;
    few.camera.position = Vec3::new(1.5, 0.4, 4.0);
    let at = |place: Vec3, scale: f32| Affine { linear: Affine::identity().linear * scale, translation: place };
    let standing = (0..40u8).map(|leaf| {
        let [x, y] = [leaf % 8, leaf / 8].map(|step| 0.35 * f32::from(step) - 1.0);
        at(Vec3::new(x, y, 0.5 + 0.03 * f32::from(leaf)), 0.1)
    });
    let placed = |transform: Affine| Instance { model: 0, transform, leaf: None };
    few.instances.extend(standing.map(placed));
    let mut many = few.clone();
    many.fallen = 1 << 18;
    many.instances.resize(few.instances.len() + many.fallen, placed(at(Vec3::new(0.0, -90.0, 0.0), 0.1)));
    let (picture, shadowless) = (raster::draw(&few).0, {
        few.view.shadow_size = 0;
        raster::draw(&few).0
    });
    assert!(picture != shadowless && raster::draw(&many).0 == picture);
}
