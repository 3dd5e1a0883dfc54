//! Transfers between real meshes whose results are known, against what the best other public programs reach.
//!
//! tests/DATA.md lists the meshes. Bounds are in percent of the target's diagonal: the requirement, then the measured value.

mod common;

use std::path::{Path, PathBuf};

use common::assert_at_most;
use mimesh::core::{
    mesh::{Mesh, Surface, SurfacePoint},
    spatial::Similarity,
    stage::{
        BindInput, Correspondence, Marker, Metric, MetricContext, MetricInput, Posed, Proximity, Transfer, TransferPair,
    },
    testkit::data::{data, read_mesh},
};
use nalgebra::{Point3, Rotation3, Vector3};

/// A pair of meshes with poses of the source and the known poses of the target.
struct Case {
    source: Surface,
    poses: Vec<Vec<Point3<f64>>>,
    target: Mesh,
    truth: Vec<Vec<Point3<f64>>>,
    markers: Vec<(u32, u32)>,
}

/// Errors in percent of the target's diagonal, over all poses.
#[derive(Debug)]
struct Score {
    mean: f64,
    rms: f64,
    placed: f64,
    /// The largest offset of any component in any pose; 0 for one component.
    component: f64,
    /// The largest error of any vertex in any pose.
    vertex: f64,
}

fn read(path: &Path) -> Mesh {
    read_mesh(path).rest
}

fn positions(paths: impl IntoIterator<Item = PathBuf>) -> Vec<Vec<Point3<f64>>> {
    paths.into_iter().map(|path| read(&path).positions).collect()
}

/// Pairs of numbers in a text, `a, b` or `"a:b"`, a pair a line.
fn pairs(path: &Path) -> Vec<(u32, u32)> {
    let text = std::fs::read_to_string(path).expect("a file of markers");
    let pair = |line: &str| {
        let numbers: Vec<u32> = line
            .split('#')
            .next()?
            .split(|c: char| !c.is_ascii_digit())
            .filter(|word| !word.is_empty())
            .filter_map(|word| word.parse().ok())
            .collect();
        (numbers.len() == 2 && !line.contains('/')).then(|| (numbers[0], numbers[1]))
    };
    text.lines().filter_map(pair).collect()
}

fn body(bodies: &Path, name: &str, landmarks: usize) -> Case {
    let (source, target) = (bodies.join("source"), bodies.join(name));
    let names = ["kick", "crouch", "twist", "stride", "reach", "bow"];
    let text = std::fs::read_to_string(target.join("landmarks.json")).expect("landmarks");
    let json: serde_json::Value = serde_json::from_str(&text).expect("landmarks in JSON");
    let side = |key: &str| {
        json[key].as_array().into_iter().flatten().filter_map(|v| Some(v.as_u64()? as u32)).collect::<Vec<_>>()
    };
    Case {
        source: Surface::new(&read(&source.join("rest.obj"))).unwrap(),
        poses: positions(names.iter().map(|n| source.join(format!("{n}.obj")))),
        truth: positions(names.iter().map(|n| target.join(format!("truth-{n}.ply")))),
        target: read(&target.join("rest.obj")),
        markers: side("source").into_iter().zip(side("target")).take(landmarks).collect(),
    }
}

fn run(case: &Case, transfer: &str) -> Score {
    run_with(case, r#"{ "type": "nonrigid_fit" }"#, transfer)
}

fn run_with(case: &Case, correspondence: &str, transfer: &str) -> Score {
    let target = Surface::new(&case.target).unwrap();
    let markers: Vec<_> = case
        .markers
        .iter()
        .enumerate()
        .map(|(k, &(s, t))| Marker {
            name: k.to_string(),
            source: SurfacePoint::Vertex(case.source.vertex_of[s as usize].expect("a vertex of a polygon")),
            target: SurfacePoint::Vertex(target.vertex_of[t as usize].expect("a vertex of a polygon")),
        })
        .collect();
    let tree: Box<dyn Proximity> = serde_json::from_str(r#"{ "type": "spanning_tree" }"#).unwrap();
    let graph = (target.components().count() > 1).then(|| tree.proximity(&target).unwrap());
    let pair = TransferPair { source: &case.source, target: &target, markers: &markers, proximity: graph.as_ref() };
    let correspondence: Box<dyn Correspondence> = serde_json::from_str(correspondence).unwrap();
    let transfer: Box<dyn Transfer> = serde_json::from_str(transfer).unwrap();
    let map = correspondence.correspond(pair).unwrap();
    let bound = transfer.bind(BindInput::new(pair, &map)).unwrap();
    let metric: Box<dyn Metric> = serde_json::from_str(r#"{ "type": "point_error" }"#).unwrap();
    let metric = metric.bind(MetricContext::alone(&case.target, &target)).unwrap();
    let count = case.poses.len() as f64;
    let mut score = Score { mean: 0.0, rms: 0.0, placed: 0.0, component: 0.0, vertex: 0.0 };
    for (pose, truth) in case.poses.iter().zip(&case.truth) {
        let posed = case.source.from_mesh(pose).unwrap();
        let result = bound.transfer(&posed).unwrap().positions;
        let result = Posed { mesh: &target.to_mesh(&result).unwrap(), surface: &result };
        let truth = Posed { mesh: truth, surface: &target.from_mesh(truth).unwrap() };
        let statistics = metric.measure(MetricInput::against(result, truth)).unwrap().statistics;
        let statistic = |name: &str| statistics.number(name).unwrap();
        score.mean += statistic("mean") / count;
        score.rms += statistic("rms").powi(2) / count;
        score.placed += statistic("placed") / count;
        score.component = score.component.max(statistics.number("comp_max").unwrap_or(0.0));
        score.vertex = score.vertex.max(statistic("max"));
    }
    score.rms = score.rms.sqrt();
    score
}

const PARTS: &str = r#"{ "type": "multi_component" }"#;
const GRADIENT: &str = r#"{ "type": "gradient" }"#;

#[test]
fn horse_poses_on_the_camel_beat_the_best_other_program() {
    let (Some(horse), Some(camel)) = (data("sumner-horse-poses"), data("sumner-camel-poses")) else { return };
    let Some(markers) = data("markers") else { return };
    let case = Case {
        source: Surface::new(&read(&horse.join("horse-reference.obj"))).unwrap(),
        poses: positions((1..=10).map(|k| horse.join(format!("horse-{k:02}.obj")))),
        target: read(&camel.join("camel-reference.obj")),
        truth: positions((1..=10).map(|k| camel.join(format!("camel-{k:02}.obj")))),
        markers: pairs(&markers.join("horse_camel.cons")),
    };
    assert_eq!(case.markers.len(), 107);
    let score = run(&case, GRADIENT);
    // The best other program has 1.84.
    assert_at_most("camel, rms", score.rms, 1.84, 1.462);
    let copied = run(&case, r#"{ "type": "copy_displacement" }"#);
    assert!(copied.rms > score.rms, "{copied:?}: copying displacements is only a baseline");
}

#[test]
fn cat_poses_on_the_lion_beat_the_best_other_program() {
    let (Some(cat), Some(lion)) = (data("sumner-cat-poses"), data("sumner-lion-poses")) else { return };
    let Some(markers) = data("markers") else { return };
    let case = Case {
        source: Surface::new(&read(&cat.join("cat-reference.obj"))).unwrap(),
        poses: positions((1..=9).map(|k| cat.join(format!("cat-{k:02}.obj")))),
        target: read(&lion.join("lion-reference.obj")),
        truth: positions((1..=9).map(|k| lion.join(format!("lion-{k:02}.obj")))),
        markers: pairs(&markers.join("markers-cat-lion.yml")),
    };
    assert_eq!(case.markers.len(), 55);
    let score = run(&case, GRADIENT);
    // The best other program has 1.02.
    assert_at_most("lion, rms", score.rms, 1.02, 0.916);
}

#[test]
fn bodies_beat_the_best_other_program_and_stand_where_they_should() {
    let Some(bodies) = data("bodies") else { return };
    // Mean errors of the best other public program on each line, and measured means and placements.
    for (name, landmarks, best, mean, placed) in [
        ("target-child", 16, 0.27, 0.200, 0.248),
        ("target-child", 64, 0.28, 0.257, 0.293),
        ("target-heavy", 16, 0.28, 0.162, 0.226),
        ("target-heavy", 64, 0.20, 0.091, 0.167),
        ("target-giant", 16, 0.34, 0.335, 0.534),
        ("target-giant", 64, 0.34, 0.337, 0.526),
    ] {
        let score = run(&body(&bodies, name, landmarks), GRADIENT);
        assert_at_most(&format!("{name}, {landmarks} landmarks, mean"), score.mean, best, mean);
        assert_at_most(&format!("{name}, {landmarks} landmarks, placed"), score.placed, score.mean + 1.0, placed);
    }
}

#[test]
fn a_target_that_is_moved_turned_and_scaled_takes_the_poses_as_well() {
    let Some(bodies) = data("bodies") else { return };
    let still = body(&bodies, "target-child", 16);
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    let place = Similarity { scale: 100.0, rotation: *turn.matrix(), translation: Vector3::new(-500.0, 40.0, 7000.0) };
    let placed = |positions: &[Point3<f64>]| positions.iter().map(|p| place.apply(p)).collect::<Vec<_>>();
    let mut moved = body(&bodies, "target-child", 16);
    moved.target.positions = placed(&still.target.positions);
    moved.truth = still.truth.iter().map(|t| placed(t)).collect();
    let (a, b) = (run(&still, GRADIENT), run(&moved, GRADIENT));
    // Equal but for rounding; the bounding box of a quarter turn has the same diagonal.
    assert!((a.mean - b.mean).abs() < 1e-3 && (a.placed - b.placed).abs() < 1e-3, "{a:?} and {b:?}");
}

#[test]
fn plates_of_a_body_move_as_one() {
    let Some(bodies) = data("bodies") else { return };
    // Every other public program leaves the plates a quarter of the body's size off.
    for (name, landmarks, mean, component) in [
        ("plates-child", 64, 0.277, 1.054),
        ("plates-heavy", 64, 0.284, 0.835),
        ("plates-child", 20, 0.277, 1.040),
        ("plates-heavy", 20, 0.321, 1.013),
    ] {
        let score = run(&body(&bodies, name, landmarks), PARTS);
        assert_at_most(&format!("{name}, {landmarks} landmarks, mean"), score.mean, 0.6, mean);
        assert_at_most(&format!("{name}, {landmarks} landmarks, worst plate"), score.component, 2.0, component);
    }
}

#[test]
fn lips_of_a_decimated_head_do_not_follow_each_other() {
    let Some(folder) = data("ict-skin") else { return };
    let names = ["jawOpen", "eyeBlink_L", "mouthPucker", "mouthSmile_L", "cheekPuff_L", "browInnerUp_L"];
    let case = Case {
        source: Surface::new(&read(&folder.join("src.obj"))).unwrap(),
        poses: positions(names.map(|n| folder.join(format!("src-{n}.obj")))),
        target: read(&folder.join("tgt.obj")),
        truth: positions(names.map(|n| folder.join(format!("truth-{n}.obj")))),
        markers: vec![],
    };
    let score = run_with(&case, r#"{ "type": "nearest" }"#, GRADIENT);
    // Every vertex is one of the source, also where decimation has turned its triangles over.
    assert_at_most("skin of the ICT face, worst vertex", score.vertex, 0.3, 0.018);
}

#[test]
fn stones_shaped_like_a_camel_take_the_poses_of_the_horse() {
    let (Some(horse), Some(stones)) = (data("sumner-horse-poses"), data("pebble-camel")) else { return };
    let Some(markers) = data("markers") else { return };
    let text = std::fs::read_to_string(stones.join("nearest.json")).expect("nearest stones");
    let json: serde_json::Value = serde_json::from_str(&text).expect("nearest stones in JSON");
    let stone = |v: u32| json["surface_vertex_to_stone_vertex"][v as usize].as_u64().expect("a vertex") as u32;
    let poses = [1, 3, 5, 8, 10];
    let case = Case {
        source: Surface::new(&read(&horse.join("horse-reference.obj"))).unwrap(),
        poses: positions(poses.map(|k| horse.join(format!("horse-{k:02}.obj")))),
        target: read(&stones.join("rest.obj")),
        truth: positions(poses.map(|k| stones.join(format!("truth-camel-{k:02}.ply")))),
        markers: pairs(&markers.join("horse_camel.cons")).into_iter().map(|(s, t)| (s, stone(t))).collect(),
    };
    let score = run(&case, PARTS);
    assert_at_most("stones, mean", score.mean, 1.8, 0.927);
    assert_at_most("stones, worst stone", score.component, 6.0, 3.511);
}

#[test]
fn heads_with_eyes_and_tongue_take_expressions_from_markers_on_the_skin() {
    let Some(bodies) = data("bodies") else { return };
    let source = Surface::new(&read(&bodies.join("face-source/rest.obj"))).unwrap();
    let markers: Vec<_> = spread_over_the_largest_component(&source, 20).into_iter().map(|v| (v, v)).collect();
    let names = [
        "jawOpen",
        "mouthSmileLeft",
        "mouthPucker",
        "eyeBlinkLeft",
        "browInnerUp",
        "cheekPuff",
        "mouthFunnel",
        "eyeLookOutLeft",
    ];
    for (face, mean, component) in
        [("face-child", 0.120, 1.094), ("face-heavy", 0.0058, 0.0415), ("face-giant", 0.0440, 0.367)]
    {
        let case = Case {
            source: source.clone(),
            poses: positions(names.map(|n| bodies.join(format!("face-source/{n}.obj")))),
            target: read(&bodies.join(face).join("rest.obj")),
            truth: positions(names.map(|n| bodies.join(face).join(format!("truth-{n}.ply")))),
            markers: markers.clone(),
        };
        let score = run(&case, PARTS);
        assert_at_most(&format!("{face}, mean"), score.mean, 0.15, mean);
        assert_at_most(&format!("{face}, worst part"), score.component, 2.0, component);
    }
}

/// Vertices of the largest component, each the farthest from those before.
fn spread_over_the_largest_component(surface: &Surface, count: usize) -> Vec<u32> {
    let components = surface.components();
    let largest = (0..components.count()).max_by_key(|&c| components.sizes[c]).map(|c| c as u32);
    let skin: Vec<u32> =
        (0..surface.vertex_count() as u32).filter(|&v| components.of_vertex[v as usize] == largest).collect();
    let mut distance = vec![f64::INFINITY; skin.len()];
    let mut chosen = vec![skin[0]];
    while chosen.len() < count {
        let last = surface.positions[chosen[chosen.len() - 1] as usize];
        for (d, &v) in distance.iter_mut().zip(&skin) {
            *d = d.min((surface.positions[v as usize] - last).norm());
        }
        let farthest = (0..skin.len()).max_by(|&a, &b| distance[a].total_cmp(&distance[b])).expect("vertices");
        chosen.push(skin[farthest]);
    }
    chosen.into_iter().map(|v| surface.representative[v as usize]).collect()
}

#[test]
fn a_face_of_56_components_takes_the_expressions_of_another() {
    let Some(folder) = data("ict-facekit") else { return };
    let mesh = |name: &str| read(&folder.join(format!("{name}.obj")));
    let (neutral, target) = (mesh("generic_neutral_mesh"), mesh("identity000"));
    let names = ["jawOpen", "eyeBlink_L", "mouthSmile_R", "cheekPuff_L", "eyeLookUp_L"];
    let poses: Vec<_> = names.iter().map(|name| mesh(name).positions).collect();
    // The model adds displacements.
    let moved = |pose: &Vec<Point3<f64>>| -> Vec<Point3<f64>> {
        let each = target.positions.iter().zip(pose).zip(&neutral.positions);
        each.map(|((at, to), from)| at + (to - from)).collect()
    };
    let truth = poses.iter().map(moved).collect();
    let mut chosen = vec![0];
    let mut distance = vec![f64::INFINITY; neutral.positions.len()];
    while chosen.len() < 30 {
        let last = neutral.positions[chosen[chosen.len() - 1]];
        distance.iter_mut().zip(&neutral.positions).for_each(|(d, p)| *d = d.min((p - last).norm()));
        let farthest = (0..distance.len()).max_by(|&a, &b| distance[a].total_cmp(&distance[b]));
        chosen.push(farthest.expect("vertices"));
    }
    let markers = chosen.into_iter().map(|v| (v as u32, v as u32)).collect();
    let score = run(&Case { source: Surface::new(&neutral).unwrap(), poses, target, truth, markers }, PARTS);
    // Every other public program leaves the parts a fifth of the head's size off.
    assert_at_most("ICT face, mean", score.mean, 0.2, 0.0300);
    assert_at_most("ICT face, worst part", score.component, 1.0, 0.349);
}
