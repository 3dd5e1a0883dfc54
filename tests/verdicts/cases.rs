//! Pairs of meshes whose results are known, in two halves: limits are chosen on one and reported on the other.

use std::path::Path;

use mimesh::core::{
    mesh::{Mesh, MeshSequence, Surface, SurfacePoint},
    stage::Generator,
    testkit::data::read_mesh,
};
use nalgebra::Point3;

/// Positions of vertices.
pub type Positions = Vec<Point3<f64>>;

/// A pair of meshes with poses.
pub struct Case {
    pub name: String,
    /// Whether limits are chosen on it; the others are reported.
    pub chooses: bool,
    pub source: Surface,
    /// Poses of the source's surface.
    pub poses: Vec<(String, Positions)>,
    pub target: Mesh,
    /// Known poses of the target's mesh.
    pub truth: Vec<Positions>,
    pub markers: Vec<(SurfacePoint, SurfacePoint)>,
    pub correspondence: &'static str,
    pub transfer: &'static str,
}

const FIT: &str = r#"{ "type": "nonrigid_fit" }"#;
const NEAREST: &str = r#"{ "type": "nearest" }"#;
const GRADIENT: &str = r#"{ "type": "gradient" }"#;
const PARTS: &str = r#"{ "type": "multi_component" }"#;

fn read(path: &Path) -> Mesh {
    read_mesh(path).rest
}

/// Judges all cases, made one at a time; with `VERDICTS_ONLY` in the environment those that have it in their names.
pub fn all(data: &Path, mut judge: impl FnMut(Case)) {
    let only = std::env::var("VERDICTS_ONLY").unwrap_or_default();
    let mut with = |name: &str, make: &dyn Fn() -> Case| {
        if name.contains(&only) {
            judge(Case { name: name.into(), ..make() });
        }
    };
    with("horse-camel", &|| animals(data, "horse", "camel", 10, "horse_camel.cons", true));
    with("cat-lion", &|| animals(data, "cat", "lion", 9, "markers-cat-lion.yml", false));
    for (target, count, chooses) in [
        ("target-child", 20, true),
        ("target-child", 64, true),
        ("target-heavy", 20, false),
        ("target-giant", 20, true),
        ("plates-child", 20, false),
        ("plates-child", 64, false),
        ("plates-heavy", 20, true),
        ("plates-heavy", 64, true),
    ] {
        with(&format!("{target}-{count}"), &|| body(data, target, count, chooses));
    }
    with("pebble-camel", &|| pebbles(data));
    for (face, chooses) in [("face-child", true), ("face-heavy", false), ("face-giant", false)] {
        with(face, &|| head(data, face, chooses));
    }
    with("identity000", &|| ict(data, "identity000", true));
    with("identity003", &|| ict(data, "identity003", false));
    with("ict-skin", &|| skin(data));
    with("links-long", &|| mannequin(data, "links-long", true));
    with("wooden-stout", &|| mannequin(data, "wooden-stout", false));
    with("wolf", &|| wolf(data));
    for (name, proportions, gait, made_of, chooses) in [
        ("made-camel", "camel", "gallop", "skin", true),
        ("made-giraffe", "giraffe", "walk", "skin", true),
        ("made-pebbles", "camel", "gallop", "pebbles", true),
        ("made-plates", "camel", "walk", "plates", false),
        ("made-boxes", "giraffe", "gallop", "boxes", false),
    ] {
        with(name, &|| made(proportions, gait, made_of, chooses));
    }
}

fn case(source: Surface, target: Mesh, chooses: bool, transfer: &'static str) -> Case {
    Case {
        name: String::new(),
        chooses,
        source,
        poses: vec![],
        target,
        truth: vec![],
        markers: vec![],
        correspondence: FIT,
        transfer,
    }
}

impl Case {
    fn with_pose(&mut self, name: &str, source: &Path, truth: Positions) {
        self.poses.push((name.to_owned(), self.source.from_mesh(&read(source).positions).unwrap()));
        self.truth.push(truth);
    }

    fn with_markers(&mut self, pairs: impl IntoIterator<Item = (u32, u32)>) {
        let target = Surface::new(&self.target).unwrap();
        let point = |surface: &Surface, v: u32| SurfacePoint::Vertex(surface.vertex_of[v as usize].unwrap());
        self.markers = pairs.into_iter().map(|(s, t)| (point(&self.source, s), point(&target, t))).collect();
    }
}

fn surface(path: &Path) -> Surface {
    Surface::new(&read(path)).unwrap()
}

fn animals(data: &Path, source: &str, target: &str, poses: usize, markers: &str, chooses: bool) -> Case {
    let folder = |name: &str| data.join(format!("sumner-{name}-poses"));
    let (from, to) = (folder(source), folder(target));
    let mut case = case(
        surface(&from.join(format!("{source}-reference.obj"))),
        read(&to.join(format!("{target}-reference.obj"))),
        chooses,
        GRADIENT,
    );
    for k in 1..=poses {
        let truth = read(&to.join(format!("{target}-{k:02}.obj"))).positions;
        case.with_pose(&format!("{k:02}"), &from.join(format!("{source}-{k:02}.obj")), truth);
    }
    case.with_markers(pairs(&data.join("markers").join(markers)));
    case
}

/// Pairs of numbers in a text, `a, b` or `"a:b"`, a pair a line.
fn pairs(path: &Path) -> Vec<(u32, u32)> {
    let text = std::fs::read_to_string(path).expect("a file of markers");
    let pair = |line: &str| {
        let line = line.split('#').next()?;
        let words = line.split(|c: char| !c.is_ascii_digit()).filter(|word| !word.is_empty());
        let numbers: Vec<u32> = words.filter_map(|word| word.parse().ok()).collect();
        (numbers.len() == 2 && !line.contains('/')).then(|| (numbers[0], numbers[1]))
    };
    text.lines().filter_map(pair).collect()
}

fn landmarks(path: &Path, count: usize) -> Vec<(u32, u32)> {
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let side = |key: &str| json[key].as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u32).collect::<Vec<_>>();
    side("source").into_iter().zip(side("target")).take(count).collect()
}

fn body(data: &Path, target: &str, count: usize, chooses: bool) -> Case {
    let (from, to) = (data.join("bodies/source"), data.join("bodies").join(target));
    let transfer = if target.starts_with("plates") { PARTS } else { GRADIENT };
    let mut case = case(surface(&from.join("rest.obj")), read(&to.join("rest.obj")), chooses, transfer);
    for name in ["kick", "crouch", "twist", "stride", "reach", "bow"] {
        let truth = read(&to.join(format!("truth-{name}.ply"))).positions;
        case.with_pose(name, &from.join(format!("{name}.obj")), truth);
    }
    case.with_markers(landmarks(&to.join("landmarks.json"), count));
    case
}

fn pebbles(data: &Path) -> Case {
    let (horse, stones) = (data.join("sumner-horse-poses"), data.join("pebble-camel"));
    let text = std::fs::read_to_string(stones.join("nearest.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let stone = |v: u32| json["surface_vertex_to_stone_vertex"][v as usize].as_u64().unwrap() as u32;
    let mut case = case(surface(&horse.join("horse-reference.obj")), read(&stones.join("rest.obj")), true, PARTS);
    for k in [1, 3, 5, 8, 10] {
        let truth = read(&stones.join(format!("truth-camel-{k:02}.ply"))).positions;
        case.with_pose(&format!("{k:02}"), &horse.join(format!("horse-{k:02}.obj")), truth);
    }
    case.with_markers(pairs(&data.join("markers/horse_camel.cons")).into_iter().map(|(s, t)| (s, stone(t))));
    case
}

fn head(data: &Path, face: &str, chooses: bool) -> Case {
    let bodies = data.join("bodies");
    let mut case =
        case(surface(&bodies.join("face-source/rest.obj")), read(&bodies.join(face).join("rest.obj")), chooses, PARTS);
    for name in ["jawOpen", "mouthSmileLeft", "mouthPucker", "eyeBlinkLeft", "browInnerUp", "eyeLookOutLeft"] {
        let truth = read(&bodies.join(face).join(format!("truth-{name}.ply"))).positions;
        case.with_pose(name, &bodies.join(format!("face-source/{name}.obj")), truth);
    }
    let components = case.source.components();
    let largest = (0..components.count()).max_by_key(|&c| components.sizes[c]).map(|c| c as u32);
    let skin: Vec<u32> =
        (0..case.source.vertex_count() as u32).filter(|&v| components.of_vertex[v as usize] == largest).collect();
    let places: Positions = skin.iter().map(|&v| case.source.positions[v as usize]).collect();
    let chosen = spread(&places, 20).into_iter().map(|k| case.source.representative[skin[k] as usize]);
    let chosen: Vec<u32> = chosen.collect();
    case.with_markers(chosen.into_iter().map(|v| (v, v)));
    case
}

fn ict(data: &Path, identity: &str, chooses: bool) -> Case {
    let folder = data.join("ict-facekit");
    let file = |name: &str| folder.join(format!("{name}.obj"));
    let neutral = read(&file("generic_neutral_mesh"));
    let mut case = case(Surface::new(&neutral).unwrap(), read(&file(identity)), chooses, PARTS);
    for name in ["jawOpen", "eyeBlink_L", "mouthSmile_R", "cheekPuff_L", "eyeLookUp_L", "browInnerUp_L", "mouthPucker"]
    {
        let pose = read(&file(name)).positions;
        // The model adds displacements.
        let each = case.target.positions.iter().zip(&pose).zip(&neutral.positions);
        let truth = each.map(|((at, to), from)| at + (to - from)).collect();
        case.with_pose(name, &file(name), truth);
    }
    let chosen = spread(&neutral.positions, 30);
    case.with_markers(chosen.into_iter().map(|v| (v as u32, v as u32)));
    case
}

fn skin(data: &Path) -> Case {
    let folder = data.join("ict-skin");
    let mut case = case(surface(&folder.join("src.obj")), read(&folder.join("tgt.obj")), true, GRADIENT);
    case.correspondence = NEAREST;
    for name in ["jawOpen", "eyeBlink_L", "mouthSmile_L", "cheekPuff_L", "browInnerUp_L", "mouthPucker"] {
        let truth = read(&folder.join(format!("truth-{name}.obj"))).positions;
        case.with_pose(name, &folder.join(format!("src-{name}.obj")), truth);
    }
    case
}

fn mannequin(data: &Path, name: &str, chooses: bool) -> Case {
    let folder = data.join("mannequins").join(name);
    let mut case = case(surface(&folder.join("source-rest.obj")), read(&folder.join("rest.obj")), chooses, PARTS);
    for pose in ["squat", "turn", "walk", "wave"] {
        let file = folder.join(format!("truth-{pose}.ply"));
        let truth = points(&file, case.target.positions.len());
        case.with_pose(pose, &folder.join(format!("source-{pose}.obj")), truth);
    }
    case.with_markers(landmarks(&folder.join("landmarks.json"), 20));
    case
}

/// The vertices of a binary PLY of `count` points without faces, x, y and z in front of other numbers of the same size.
fn points(path: &Path, count: usize) -> Positions {
    let bytes = std::fs::read(path).unwrap();
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let row = (bytes.len() - start) / count;
    let double = String::from_utf8_lossy(&bytes[..start]).contains("property double x");
    let number = |at: usize| match double {
        true => f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()),
        false => f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())),
    };
    let size = if double { 8 } else { 4 };
    (0..count)
        .map(|v| start + v * row)
        .map(|at| Point3::new(number(at), number(at + size), number(at + 2 * size)))
        .collect()
}

/// The wolf takes its own poses.
fn wolf(data: &Path) -> Case {
    let folder = data.join("cragl-mit-wolf");
    let mut case = case(surface(&folder.join("wolf.obj")), read(&folder.join("wolf.obj")), false, PARTS);
    for k in 1..=6 {
        let file = folder.join(format!("wolf-{k}.obj"));
        case.with_pose(&k.to_string(), &file, read(&file).positions);
    }
    let chosen = spread(&case.target.positions, 30);
    case.with_markers(chosen.into_iter().map(|v| (v as u32, v as u32)));
    case
}

fn made(proportions: &str, gait: &str, made_of: &str, chooses: bool) -> Case {
    let make = |proportions: &str, made_of: &str, seed: u32| -> MeshSequence {
        let settings = serde_json::json!({ "type": "quadruped", "proportions": proportions, "gait": gait,
            "made_of": made_of, "seed": seed, "resolution": 40 });
        let generator: Box<dyn Generator> = serde_json::from_value(settings).unwrap();
        generator.make().unwrap()
    };
    let (horse, animal) = (make("horse", "skin", 0), make(proportions, made_of, 1));
    let transfer = if made_of == "skin" { GRADIENT } else { PARTS };
    let mut case = case(Surface::new(&horse.rest).unwrap(), animal.rest.clone(), chooses, transfer);
    let target = Surface::new(&animal.rest).unwrap();
    for landmark in &horse.landmarks {
        if let Some(other) = animal.landmarks.iter().find(|other| other.name == landmark.name) {
            let pair = (case.source.point(landmark.point).unwrap(), target.point(other.point).unwrap());
            case.markers.push(pair);
        }
    }
    case.poses = horse
        .poses
        .iter()
        .map(|p| (p.name.clone(), case.source.from_mesh(&p.positions.get().unwrap()).unwrap()))
        .collect();
    case.truth = animal.poses.into_iter().map(|pose| pose.positions.get().unwrap().into_owned()).collect();
    case
}

/// Numbers of `count` points, each the farthest from those before.
fn spread(points: &[Point3<f64>], count: usize) -> Vec<usize> {
    let mut chosen = vec![0];
    let mut distance = vec![f64::INFINITY; points.len()];
    while chosen.len() < count {
        let last = points[chosen[chosen.len() - 1]];
        distance.iter_mut().zip(points).for_each(|(d, p)| *d = d.min((p - last).norm()));
        chosen.push((0..points.len()).max_by(|&a, &b| distance[a].total_cmp(&distance[b])).unwrap());
    }
    chosen
}
