//! Generated meshes that the benches share, and how the benches run.

// Each bench uses a part of it.
#![allow(dead_code)]

use std::{
    collections::BTreeMap,
    sync::{Mutex, OnceLock},
    time::Duration,
};

use mimesh::core::{
    mesh::{MeshSequence, Surface, SurfacePoint},
    plugin::{StageKind, configured},
    stage::{
        BindInput, Correspondence, Generator, Marker, Proximity, ProximityGraph, Sampler, Transfer, TransferPair,
        TriangleMap, Work,
    },
};
use nalgebra::Point3;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// About how many triangles a mesh of one piece has; each has four times as many as the one before.
pub const FACES: [usize; 4] = [2_500, 10_000, 40_000, 160_000];

/// How many pieces a mesh of several has. All have one length of edges, so that 50 pieces have some 25,000 triangles and 800 have 64,000.
pub const PIECES: [usize; 3] = [50, 200, 800];

/// Runs all benches of a file.
///
/// Stages take milliseconds to seconds, so a sample is one call. A bench ends after two seconds unless the command line asks for
/// more.
pub fn main() {
    divan::Divan::default().sample_count(20).sample_size(1).max_time(Duration::from_secs(2)).config_with_args().main();
}

/// The stage of kind `S` with these settings.
pub fn stage<S: StageKind + ?Sized>(settings: Value) -> Box<S>
where
    Box<S>: DeserializeOwned,
{
    configured(settings.clone()).unwrap_or_else(|| panic!("no {} is {settings}", S::NAME))
}

/// The stage of kind `S` of this name, with its default settings.
pub fn default_stage<S: StageKind + ?Sized>(name: &str) -> Box<S>
where
    Box<S>: DeserializeOwned,
{
    stage(json!({ "type": name }))
}

/// What a mesh is made as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shape {
    /// A horse with about this many triangles.
    Horse(usize),
    /// A camel with about this many triangles.
    Camel(usize),
    /// A camel of about this many pebbles.
    Pebbles(usize),
    /// A camel in about this many plates.
    Plates(usize),
}

/// A made animal with a gallop of four frames.
pub struct Animal {
    /// The mesh with its poses and named points.
    pub mesh: MeshSequence,
    /// The surface that stages see.
    pub surface: Surface,
}

impl Animal {
    /// Positions of the surface's vertices in pose `k`.
    pub fn pose(&self, k: usize) -> Vec<Point3<f64>> {
        self.surface.from_mesh(&self.mesh.poses[k].positions.get().expect("held")).expect("a pose of the mesh")
    }

    /// Positions of the surface's vertices in all poses.
    pub fn poses(&self) -> Vec<Vec<Point3<f64>>> {
        (0..self.mesh.poses.len()).map(|k| self.pose(k)).collect()
    }

    /// `count` points, spread over the surface.
    pub fn points(&self, count: usize) -> Vec<SurfacePoint> {
        let sampler = stage::<dyn Sampler>(json!({ "type": "farthest_point", "count": count }));
        sampler.sample(&self.surface).expect("points")
    }
}

/// The settings of the generator that makes `shape`.
pub fn settings(shape: Shape) -> Value {
    // Triangles of the default resolution of 60.
    let resolution = |faces: usize, at_60: f64| (60.0 * (faces as f64 / at_60).sqrt()).round() as usize;
    let (proportions, made_of, resolution, pieces) = match shape {
        Shape::Horse(faces) => ("horse", "skin", resolution(faces, 13_800.0), None),
        Shape::Camel(faces) => ("camel", "skin", resolution(faces, 15_400.0), None),
        Shape::Pebbles(pieces) => ("camel", "pebbles", 60, Some(pieces)),
        Shape::Plates(pieces) => ("camel", "plates", 60, Some(pieces)),
    };
    let seed = u64::from(proportions == "camel");
    json!({
        "type": "quadruped", "gait": "gallop", "frames": 4, "proportions": proportions, "made_of": made_of, "pieces": pieces,
        "resolution": resolution.max(20), "seed": seed,
    })
}

/// The animal of this shape; made once.
pub fn animal(shape: Shape) -> &'static Animal {
    static MADE: Mutex<BTreeMap<Shape, &'static Animal>> = Mutex::new(BTreeMap::new());
    let mut made = MADE.lock().expect("no bench has panicked");
    let animal: &mut &'static Animal = made.entry(shape).or_insert_with(|| {
        let mesh = stage::<dyn Generator>(settings(shape)).make().expect("an animal");
        let surface = Surface::new(&mesh.rest).expect("a surface");
        Box::leak(Box::new(Animal { mesh, surface }))
    });
    animal
}

/// A horse of as many triangles as its target, and the target.
pub struct Pair {
    /// The horse.
    pub source: &'static Animal,
    /// The camel.
    pub target: &'static Animal,
    /// The named points of both.
    pub markers: Vec<Marker>,
    /// The neighbours among the components of the target, where it has several.
    pub proximity: Option<ProximityGraph>,
    map: OnceLock<TriangleMap>,
    poses: Vec<Vec<Point3<f64>>>,
}

impl Pair {
    /// The rest surfaces with all markers.
    pub fn surfaces(&self) -> TransferPair<'_> {
        self.with_markers(&self.markers)
    }

    /// The rest surfaces with some markers.
    pub fn with_markers<'a>(&'a self, markers: &'a [Marker]) -> TransferPair<'a> {
        let (source, target) = (&self.source.surface, &self.target.surface);
        TransferPair { source, target, markers, proximity: self.proximity.as_ref() }
    }

    /// Twelve markers, spread over the body.
    pub fn twelve_markers(&self) -> Vec<Marker> {
        let step = self.markers.len() / 12;
        self.markers.iter().step_by(step).take(12).cloned().collect()
    }

    /// What a transfer is bound to, along the map of `nonrigid_fit`.
    pub fn bind_input<'a>(&'a self, transfer: &dyn Transfer, markers: &'a [Marker]) -> BindInput<'a> {
        let poses = &self.poses[..transfer.poses_wanted().min(self.poses.len())];
        BindInput { pair: self.with_markers(markers), map: Some(self.map()), poses, work: Work::UNWATCHED }
    }

    /// The map of `nonrigid_fit`; made once.
    pub fn map(&self) -> &TriangleMap {
        let fit = || default_stage::<dyn Correspondence>("nonrigid_fit").correspond(self.surfaces()).expect("a map");
        self.map.get_or_init(fit)
    }
}

/// A horse and a target of this shape; made once.
pub fn pair(target: Shape) -> &'static Pair {
    static MADE: Mutex<BTreeMap<Shape, &'static Pair>> = Mutex::new(BTreeMap::new());
    let mut made = MADE.lock().expect("no bench has panicked");
    let pair: &mut &'static Pair = made.entry(target).or_insert_with(|| {
        let faces = if let Shape::Horse(faces) | Shape::Camel(faces) = target { faces } else { 14_000 };
        Box::leak(Box::new(new_pair(animal(Shape::Horse(faces)), animal(target))))
    });
    pair
}

fn new_pair(source: &'static Animal, target: &'static Animal) -> Pair {
    let place = |animal: &Animal, name: &str| {
        let landmark = animal.mesh.landmarks.iter().find(|landmark| landmark.name == name)?;
        animal.surface.point(landmark.point)
    };
    let names = source.mesh.landmarks.iter().map(|landmark| landmark.name.clone());
    let marker = |name: String| {
        let (source, target) = (place(source, &name)?, place(target, &name)?);
        Some(Marker { name, source, target })
    };
    let markers = names.filter_map(marker).collect();
    let has_parts = target.surface.components().count() > 1;
    let graph = || default_stage::<dyn Proximity>("spanning_tree").proximity(&target.surface).expect("a graph");
    let proximity = has_parts.then(graph);
    Pair { source, target, markers, proximity, map: OnceLock::new(), poses: source.poses() }
}
