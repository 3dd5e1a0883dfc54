//! Statistics against those that trimesh and libigl compute, through `peers.py`.
//!
//! Runs where MIMESH_PEERS names a Python that has both: `pip install trimesh libigl scipy`, then
//! `MIMESH_PEERS=venv/bin/python cargo test --release -p mimesh-metrics --test peers`.

use std::{
    io::Write,
    path::Path,
    process::{Command, Stdio},
};

use mimesh_core::{
    Figures,
    mesh::{Mesh, Surface},
    plugin,
    stage::{Metric, MetricContext, MetricInput, Posed},
    testkit::data::{data, missing, read_mesh},
};
use mimesh_formats as _;
use mimesh_metrics as _;
use nalgebra::Point3;
use serde_json::{Value, json};

/// Sums over 80,000 triangles in another order, of percentages.
const TOLERANCE: f64 = 1e-9;

/// Rest mesh and pose, and whether crossings are looked for too.
const CASES: [(&str, &str, bool); 4] = [
    ("sumner-horse-poses/horse-reference.obj", "sumner-horse-poses/horse-05.obj", true),
    ("sumner-camel-poses/camel-reference.obj", "sumner-camel-poses/camel-03.obj", false),
    ("bodies/target-child/rest.obj", "bodies/target-child/truth-crouch.ply", true),
    ("pebble-camel/rest.obj", "pebble-camel/truth-camel-01.ply", false),
];

#[test]
fn areas_edges_volumes_components_and_crossings_are_those_of_trimesh_and_libigl() {
    let Ok(python) = std::env::var("MIMESH_PEERS") else {
        return missing("MIMESH_PEERS", "name a Python with trimesh, libigl and scipy in it");
    };
    let Some(data) = data("") else { return };
    let read = |file: &str| read(&data.join(file));
    let cases: Vec<_> = CASES
        .iter()
        .map(|(rest, pose, crossings)| {
            let mesh = read(rest);
            let surface = Surface::new(&mesh).unwrap();
            (mesh, surface, read(pose).positions, *crossings)
        })
        .collect();
    let found = ask(&python, &cases);
    for ((name, ..), ((mesh, surface, posed, crossings), peer)) in CASES.iter().zip(cases.iter().zip(&found)) {
        let measure = |metric: &str| measure(metric, mesh, surface, posed);
        assert_eq!(peer["components"], surface.components().count(), "{name}");
        assert_eq!(peer["trimesh_components"], surface.components().count(), "{name}");
        for (metric, statistic) in
            ["edge_stretch", "area_change"].iter().flat_map(|m| ["p99", "max", "median", "left_out"].map(|f| (*m, f)))
        {
            let statistics = measure(metric);
            assert_near(name, metric, statistics.number(statistic), &peer[metric][statistic], TOLERANCE);
        }
        if let Some(volume) = peer.get("volume") {
            let change = measure("volume").number("change");
            assert_near(name, "volume by trimesh", change, &volume["change"], TOLERANCE);
            assert_near(name, "volume by libigl", change, &volume["igl_change"], TOLERANCE);
        }
        if *crossings {
            let share = measure("self_intersections").number("share");
            // Exact arithmetic also counts what touches; ours only what goes deeper than a millionth of the diagonal.
            assert_near(name, "self_intersections", share, &peer["self_intersections"]["share"], 0.02);
            assert!(share.unwrap() > 0.0, "{name}: the pose was chosen for its crossings");
        }
    }
}

fn read(file: &Path) -> Mesh {
    read_mesh(file).rest
}

fn measure(name: &str, mesh: &Mesh, surface: &Surface, posed: &[Point3<f64>]) -> Figures {
    let (_, metric) = plugin::instances::<dyn Metric>().into_iter().find(|(n, _)| *n == name).unwrap();
    let posed = Posed { mesh: posed, surface: &surface.from_mesh(posed).unwrap() };
    metric.bind(MetricContext::alone(mesh, surface)).unwrap().measure(MetricInput::alone(posed)).unwrap().statistics
}

fn ask(python: &str, cases: &[(Mesh, Surface, Vec<Point3<f64>>, bool)]) -> Vec<Value> {
    let case = |(_, surface, posed, crossings): &(Mesh, Surface, Vec<Point3<f64>>, bool)| {
        let plain = |positions: &[Point3<f64>]| positions.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>();
        let (rest, pose) = (plain(&surface.positions), plain(&surface.from_mesh(posed).unwrap()));
        json!({ "triangles": surface.triangles, "rest": rest, "pose": pose, "crossings": crossings })
    };
    let asked = serde_json::to_vec(&cases.iter().map(case).collect::<Vec<_>>()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers.py");
    let mut child = Command::new(python)
        .arg(script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("MIMESH_PEERS={python}: {error}"));
    child.stdin.take().unwrap().write_all(&asked).unwrap();
    let answer = child.wait_with_output().unwrap();
    assert!(answer.status.success(), "peers.py failed");
    serde_json::from_slice(&answer.stdout).unwrap()
}

#[track_caller]
fn assert_near(name: &str, what: &str, found: Option<f64>, expected: &Value, tolerance: f64) {
    let (found, expected) = (found.unwrap(), expected.as_f64().unwrap());
    assert!((found - expected).abs() <= tolerance * (1.0 + expected.abs()), "{name}: {what}: {found}, {expected}");
}
