//! The contracts of stages, as checks that hold any implementation to them; they panic with the name and what is wrong.
//!
//! mimesh runs them over its whole registry; a plug-in runs them on its own stages the same way.

use nalgebra::Point3;
use serde_json::Value;

pub use super::{
    clusterer::clusterer, deformer::deformer, format::format, key_points::key_points, metric::metric,
    registered::keeps, sampler::sampler, weights::weights,
};
use super::{meshes, random::Random};
use crate::{
    Plugin,
    mesh::{Surface, SurfacePoint, diagonal},
    plugin::StageKind,
    stage::{BoundTransfer, Correspondence, Generator, Marker, Proximity, Transfer, TransferPair, TriangleMap},
};

/// Rounding through one factorisation and solve of these small meshes, relative to the diagonal.
const TOLERANCE: f64 = 1e-9;

/// What every registered implementation keeps: it says its name and its settings, and each setting what it means.
pub fn described(plugin: &Plugin) {
    let name = (plugin.name)();
    let schema = (plugin.schema)(&mut schemars::SchemaGenerator::default());
    let documented = |schema: &Value| schema.get("description").and_then(Value::as_str).is_some_and(|d| !d.is_empty());
    assert!(documented(schema.as_value()), "{name} has no doc comment");
    for (key, setting) in schema.get("properties").and_then(Value::as_object).into_iter().flatten() {
        assert!(documented(setting), "{name}.{key} has no doc comment");
    }
    assert!((plugin.settings)().is_object(), "{name}: settings are not a mapping");
}

/// Settings written out and read again are the same settings.
pub fn round_trips<S>(name: &str, stage: &S)
where
    S: StageKind + ?Sized + serde::Serialize,
    Box<S>: serde::de::DeserializeOwned,
{
    let written = serde_json::to_value(stage).unwrap_or_else(|error| panic!("{name} does not serialise: {error}"));
    assert_eq!(written["type"], name, "{name} is tagged by its own name");
    let read: Box<S> =
        serde_json::from_value(written.clone()).unwrap_or_else(|error| panic!("{name} does not read back: {error}"));
    let again = serde_json::to_value(&*read).unwrap_or_else(|error| panic!("{name} does not serialise: {error}"));
    assert_eq!(written, again, "{name} changes when written and read");
}

/// The contract of [`Correspondence`].
pub fn correspondence(name: &str, stage: &dyn Correspondence) {
    let surface = bent_bar();
    let markers: Vec<_> = (0..surface.vertex_count() as u32)
        .step_by(10)
        .map(|v| Marker { name: v.to_string(), source: SurfacePoint::Vertex(v), target: SurfacePoint::Vertex(v) })
        .collect();
    let pair = TransferPair { source: &surface, target: &surface, markers: &markers, proximity: None };
    let run = || stage.correspond(pair).unwrap_or_else(|error| panic!("{name}: {error}"));
    let map = run();
    map.check(pair).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(map == one_thread(run), "{name}: another map on one thread");
    let barycentres = surface.barycentres(&surface.positions);
    let edge =
        surface.triangles.iter().map(|t| (surface.positions[t[0] as usize] - surface.positions[t[1] as usize]).norm());
    let edge = edge.fold(0.0, f64::max);
    for (t, partner) in map.partners.iter().enumerate() {
        let Some(partner) = *partner else {
            panic!("{name}: triangle {t} of a surface paired with itself is an orphan")
        };
        let distance = (barycentres[t] - barycentres[partner as usize]).norm();
        assert!(distance <= edge, "{name}: triangle {t} paired with itself gives {partner}, {distance} away");
    }
}

/// The contract of [`Transfer`], on a sound surface and on one with defects, along triangles and along points.
pub fn transfer(name: &str, stage: &dyn Transfer) {
    for source in [bent_bar(), with_defects(bent_bar())] {
        for by_points in [false, true] {
            transfer_between(name, stage, &source, &stretched(&source), by_points);
        }
    }
}

fn transfer_between(name: &str, stage: &dyn Transfer, source: &Surface, target: &Surface, by_points: bool) {
    let points = (0..source.vertex_count() as u32).map(|v| Some(SurfacePoint::Vertex(v)));
    let map = TriangleMap {
        source_triangles: source.triangle_count(),
        partners: (0..source.triangle_count() as u32).map(Some).collect(),
        points: if by_points { points.collect() } else { vec![] },
        ..TriangleMap::default()
    };
    let markers: Vec<_> = (0..4)
        .map(|k| k * 7)
        .map(|v| Marker { name: v.to_string(), source: SurfacePoint::Vertex(v), target: SurfacePoint::Vertex(v) })
        .collect();
    let bind = |target: &Surface| {
        let pair = TransferPair { source, target, markers: &markers, proximity: None };
        stage.bind(pair, &map).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let run = |bound: &dyn BoundTransfer, posed: &[Point3<f64>]| {
        bound.transfer(posed).unwrap_or_else(|error| panic!("{name}: {error}")).positions
    };

    let bound = bind(target);
    near(name, "the source at rest gives the target at rest", &run(&*bound, &source.positions), &target.positions);

    let onto_itself = bind(source);
    for seed in 0..5 {
        let motion = Random::new(seed).rigid_motion(source.diagonal());
        let moved: Vec<_> = source.positions.iter().map(|p| motion * p).collect();
        near(name, "a rigid motion of the source moves the target by it", &run(&*onto_itself, &moved), &moved);
    }

    let (pose, other) = (twisted(source, 1.0), twisted(source, -0.5));
    let first = run(&*bound, &pose);
    assert_eq!(first.len(), target.vertex_count(), "{name}: one position a target vertex");
    assert!(first.iter().all(|p| p.coords.iter().all(|x| x.is_finite())), "{name}: results are finite");
    run(&*bound, &other);
    assert!(first == run(&*bound, &pose), "{name}: another result after another pose");
    assert!(first == one_thread(|| run(&*bind(target), &pose)), "{name}: another result on one thread");

    assert!(bound.transfer(&pose[1..]).is_err(), "{name}: takes a pose with a vertex too few");
    let mut broken = pose;
    broken[3].y = f64::NAN;
    assert!(bound.transfer(&broken).is_err(), "{name}: takes a pose with NaN");
}

/// The contract of [`Proximity`].
pub fn proximity(name: &str, stage: &dyn Proximity) {
    let target = scattered_bars();
    let run = || stage.proximity(&target).unwrap_or_else(|error| panic!("{name}: {error}"));
    let graph = run();
    graph.check(&target).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(graph == one_thread(run), "{name}: another graph on one thread");
    assert_eq!(graph.components, target.components(), "{name}: components are those of the surface");
    let mut reached = vec![false; graph.components.count()];
    reached[0] = true;
    for _ in 0..reached.len() {
        for [a, b] in graph.links.iter().map(|link| link.components.map(|c| c as usize)) {
            let joined = reached[a] || reached[b];
            (reached[a], reached[b]) = (joined, joined);
        }
    }
    assert!(reached.iter().all(|r| *r), "{name}: some components are not joined to the rest");
    for link in &graph.links {
        assert!(!link.pairs.is_empty() && link.components[0] < link.components[1], "{name}: {link:?}");
        for pair in &link.pairs {
            let of = pair.map(|v| graph.components.of_vertex[v as usize]);
            assert_eq!(of, link.components.map(Some), "{name}: pair {pair:?} joins other components");
        }
    }
}

/// The contract of [`Generator`].
pub fn generator(name: &str, stage: &dyn Generator) {
    let make = || stage.make().unwrap_or_else(|error| panic!("{name}: {error}"));
    let sequence = make();
    sequence.rest.validate().unwrap_or_else(|error| panic!("{name}: {error}"));
    for pose in &sequence.poses {
        assert_eq!(pose.positions.len(), sequence.rest.positions.len(), "{name}: pose {}", pose.name);
        assert!(pose.positions.iter().all(|p| p.coords.iter().all(|x| x.is_finite())), "{name}: pose {}", pose.name);
    }
    let again = one_thread(make);
    assert!(again.rest.positions == sequence.rest.positions && again.poses == sequence.poses, "{name}: not repeatable");
}

pub(super) fn one_thread<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    pool.install(run)
}

pub(super) fn near(name: &str, law: &str, found: &[Point3<f64>], expected: &[Point3<f64>]) {
    near_within(name, law, found, expected, TOLERANCE);
}

pub(super) fn near_within(name: &str, law: &str, found: &[Point3<f64>], expected: &[Point3<f64>], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{name}: {law}");
    let size = diagonal(expected);
    for (v, (p, q)) in found.iter().zip(expected).enumerate() {
        let error = (p - q).norm() / size;
        assert!(error < tolerance, "{name}: {law}: vertex {v} is {error:e} diagonals off");
    }
}

/// A bar without symmetry.
pub(super) fn bent_bar() -> Surface {
    let mut surface = meshes::bar([9, 3, 2], [3.0, 0.9, 0.7]);
    for p in &mut surface.positions {
        *p = Point3::new(p.x, p.y + 0.1 * p.x * p.x, p.z * (1.0 + 0.2 * p.x));
    }
    surface
}

/// With a triangle that has a corner twice, as poles of exported spheres have, one without area, and a loose vertex.
pub(super) fn with_defects(surface: Surface) -> Surface {
    let (mut positions, mut triangles) = (surface.positions, surface.triangles);
    let [a, b, _] = triangles[7];
    triangles.push([a, a, b]);
    let middle = nalgebra::center(&positions[a as usize], &positions[b as usize]);
    positions.push(middle);
    triangles.push([a, b, positions.len() as u32 - 1]);
    positions.push(Point3::new(0.3, 2.0, 0.1));
    Surface::from_triangles(positions, triangles).expect("finite positions and existing corners")
}

/// Bars of one size at places without order, some of which overlap.
fn scattered_bars() -> Surface {
    let bar = meshes::bar([3, 1, 1], [1.0, 0.3, 0.3]);
    let mut random = Random::new(5);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for _ in 0..12 {
        let start = positions.len() as u32;
        let motion = random.rigid_motion(2.0);
        positions.extend(bar.positions.iter().map(|p| motion * p));
        triangles.extend(bar.triangles.iter().map(|t| t.map(|v| v + start)));
    }
    Surface::from_triangles(positions, triangles).expect("finite positions and existing corners")
}

/// The same topology with other proportions, of the same mean size.
fn stretched(surface: &Surface) -> Surface {
    let mut result = surface.clone();
    result.positions.iter_mut().for_each(|p| *p = Point3::new(1.3 * p.x, 0.8 * p.y, 0.9 * p.z));
    result
}

/// Turned about x in proportion to x: `angle` radians a unit of length.
pub(super) fn twisted(surface: &Surface, angle: f64) -> Vec<Point3<f64>> {
    let turn = |p: &Point3<f64>| nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), angle * p.x) * p;
    surface.positions.iter().map(turn).collect()
}
