#![allow(missing_docs, dead_code, unused)]
use leafseason::base::{mesh::Mesh, vector::*, picture::Picture, limits::Limits, random::*};
use leafseason::frame::*;
use leafseason::{raster, tree, base, frame};
mod scene { pub struct Light { pub sun_elevation: f64, pub sun_azimuth: f64, pub sun: f64, pub sky: f64, pub exposure: f64 } impl Default for Light { fn default() -> Self { Self{sun_elevation:34.0,sun_azimuth:55.0,sun:1.0,sky:1.0,exposure:0.0} } } }
#[path = "../src/compose/noise.rs"] mod noise;
#[path = "../src/compose/ground.rs"] mod ground;
#[path = "../src/compose/bark.rs"] mod bark;
#[path = "../src/compose/petiole.rs"] mod petiole;
#[path = "../src/compose/light.rs"] mod light;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string("src/species/red-maple.tree.toml").unwrap();
    let table: toml::Table = text.parse().unwrap();
    let settings: tree::Settings = table["tree"].clone().try_into().unwrap();
    let t0 = std::time::Instant::now();
    let (tree, figures) = tree::grow(&settings, 7, &Limits::default()).unwrap();
    eprintln!("tree {:?} {:?} h {} r {} bark {} twig {}", t0.elapsed(), figures.values, tree.height, tree.crown_radius, tree.bark.triangles.len(), tree.twigs.triangles.len());
    // rough leaf
    let half = [(0.0,0.0),(8.,-4.),(16.,-5.),(20.,4.),(30.,9.),(24.,14.),(30.,24.),(42.,36.),(33.,38.),(30.,46.),(20.,42.),(15.,40.),(17.,50.),(22.,60.),(12.,62.),(8.,72.),(0.,82.)];
    let mut pts: Vec<(f64,f64)> = half.to_vec();
    for p in half.iter().rev().skip(1).take(half.len()-2) { pts.push((-p.0,p.1)); }
    let states = [("green",[0.035,0.062,0.012],[0.055,0.08,0.002]),("turn",[0.21,0.13,0.02],[0.26,0.16,0.003]),("yellow",[0.42,0.24,0.02],[0.42,0.22,0.005]),("orange",[0.37,0.14,0.02],[0.38,0.14,0.015]),("red",[0.29,0.05,0.025],[0.28,0.045,0.015]),("brown",[0.2,0.11,0.055],[0.12,0.06,0.02])];
    let mut f = Frame { meshes: vec![], textures: vec![bark::texture([0.21,0.19,0.165], 1), ground::texture(1)], materials: vec![], models: vec![], instances: vec![], camera: Camera{position:Vec3::zeros(),target:Vec3::zeros(),field_of_view:0.35,near:0.05,far:1000.0}, sun: Sun{direction:Vec3::y(),irradiance:[0.0;3]}, sky: Sky{zenith:[0.0;3],horizon:[0.0;3]}, ground: Some(ground::ground(1)), view: View{width:1920,height:1080,samples:8,shadow_size:2048,exposure:1.0,tone_map:ToneMap::Neutral} };
    let wood = |name: &str, c: [f32;3], t: Option<u32>| Material{name:name.into(),colour:c,reflected:t,transmission:[0.0;3],transmitted:None,back_gain:1.0,gloss:0.0,roughness:0.9,two_sided:false};
    f.meshes.push(tree.bark.clone()); f.meshes.push(tree.twigs.clone());
    f.materials.push(wood("bark",[1.0;3],Some(0))); f.materials.push(wood("twig",[0.13,0.09,0.08],None)); f.materials.push(wood("petiole",[0.3,0.09,0.07],None));
    f.models.push(Model{name:"trunk".into(),parts:vec![Part{mesh:0,material:0},Part{mesh:1,material:1}]});
    let bend = settings.petiole_angle.to_radians(); let lp = settings.petiole*1e-3;
    f.meshes.push(petiole::mesh(lp, bend));
    let base = petiole::base(lp, bend);
    for curl in 0..3 { let mut m = Mesh::default();
        let z = |x: f64, y: f64| { let r = (x*x + (y-35.)*(y-35.)).sqrt()/45.; let c = [0.1,0.35,0.6][curl]; (c*(x.abs()/45.).powi(2)*22. - c*r*r*r*8. + 2.0*(x*0.15+curl as f64).sin()) };
        m.positions.push(Vec3::new(0.,0.03,(z(0.,30.)*1e-3) as f32)); m.uvs.push(Vec2::zeros());
        for p in &pts { m.positions.push(Vec3::new((p.0*1e-3) as f32,(p.1*1e-3) as f32,(z(p.0,p.1)*1e-3) as f32)); m.uvs.push(Vec2::zeros()); }
        let n = pts.len() as u32; for i in 0..n { m.triangles.push([0, 1+i, 1+(i+1)%n]); }
        m.recompute_normals(); if m.normals[0].z < 0.0 { for t in &mut m.triangles { t.swap(1,2); } m.recompute_normals(); }
        f.meshes.push(m); }
    for (name, r, t) in states { f.materials.push(Material{name:name.into(),colour:r,reflected:None,transmission:t,transmitted:None,back_gain:1.35,gloss:0.034,roughness:0.42,two_sided:true});
        for curl in 0..3u32 { f.models.push(Model{name:format!("l{name}{curl}"),parts:vec![Part{mesh:3+curl,material:f.materials.len() as u32-1},Part{mesh:2,material:2}]}); } }
    f.instances.push(Instance{model:0,transform:Affine::identity(),leaf:None});
    let season: toml::Table = std::fs::read_to_string("src/species/red-maple.season.toml").unwrap().parse().unwrap();
    let ss: leafseason::season::Settings = season["season"].clone().try_into().unwrap();
    let climate = leafseason::season::Climate { temperature: 9.0, humidity: 0.7 };
    let ids: Vec<u64> = tree.sites.iter().map(|s| s.id).collect();
    let day: f64 = args.get(1).map_or(9.0, |d| d.parse().unwrap());
    let (st, _) = leafseason::season::assign(&ss, &climate, 7, &ids, day);
    let map = |name: &str| match name { "flush"|"green" => 0, "late-green" => 0, "turning" => 1, "yellow" => 2, "red" => 4, "brown" => 5, _ => 99 };
    let mut cnt = std::collections::BTreeMap::new();
    for (i, site) in tree.sites.iter().enumerate() { let name = &st.names[st.states[i] as usize]; *cnt.entry(name.clone()).or_insert(0) += 1; let k = map(name); if k == 99 { continue; }
        let rot = nalgebra::Matrix3::from_columns(&[site.blade.cross(&site.normal), site.blade, site.normal]);
        let lin: Mat3 = (rot*site.scale).cast::<f32>();
        f.instances.push(Instance{model: 1 + k*3 + (hash(site.id,1)%3) as u32, transform: Affine{linear:lin,translation:site.base.cast::<f32>()-lin*base}, leaf:Some(site.id)}); }
    eprintln!("{cnt:?}");
    let fov: f64 = 20f64.to_radians();
    let (d, tilt) = light::fitted(tree.height, tree.crown_radius, 1.6, fov, 16.0/9.0, 0.84);
    f.camera.position = Vec3::new(0.0,1.6,d as f32); f.camera.target = Vec3::new(0.0,(1.6+d*tilt.tan()) as f32,0.0); f.camera.field_of_view = fov as f32;
    let l = light::lighting(&scene::Light::default(), DVec3::new(0.0,0.0,-1.0)); f.sun=l.sun; f.sky=l.sky; f.view.exposure=l.exposure;
    let t0 = std::time::Instant::now(); let (p, fig) = raster::draw(&f); eprintln!("raster {:?} {:?}", t0.elapsed(), fig.values);
    let t0 = std::time::Instant::now(); let (p, fig) = raster::draw(&f); eprintln!("raster {:?}", t0.elapsed());
    let file = std::fs::File::create(args.get(2).map_or("/tmp/preview.png", |s| s)).unwrap();
    let mut e = png::Encoder::new(file, p.width, p.height); e.set_color(png::ColorType::Rgba); let mut w = e.write_header().unwrap();
    w.write_image_data(&p.pixels.concat()).unwrap();
}
