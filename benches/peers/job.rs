use std::{
    fs,
    path::{Path, PathBuf},
};

use mimesh::core::{
    mesh::{Mesh, MeshSequence, Pose, Surface, SurfacePoint},
    spatial::{ClosestPoint, EdgePaths},
    stage::{
        BindInput, BytesInput, Clusterer, Correspondence, Deformer, Format, Generator, MeshWriter, Proximity,
        ProximityGraph, Sampler, Selection, Transfer, TransferPair, TriangleMap, Weights, Work,
    },
};
use nalgebra::Point3;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::{
    clock::Clock,
    files::{Failure, Folder, markers, points, write_numbers, write_points},
};

/// What is run. Paths of meshes are those of a [`Folder`].
#[derive(Debug, Deserialize)]
#[serde(tag = "task", rename_all = "snake_case", deny_unknown_fields)]
pub enum Job {
    /// Makes a mesh and spreads handles over it.
    Make { generator: Box<dyn Generator>, handles: Box<dyn Sampler>, mesh: PathBuf },
    /// Takes the mesh in a file and its poses in others, and spreads handles over it.
    Import { format: Box<dyn Format>, file: PathBuf, poses: Vec<PathBuf>, handles: Box<dyn Sampler>, mesh: PathBuf },
    /// Binds weights to a mesh and solves for its first handles. The result is W, a column a handle.
    Weights {
        mesh: PathBuf,
        weights: Box<dyn Weights>,
        handles: usize,
        proximity: Option<Box<dyn Proximity>>,
        result: PathBuf,
    },
    /// Fits the maps of handles to pose 0. The result is the vertices where they bring the mesh.
    Deform {
        mesh: PathBuf,
        weights: Box<dyn Weights>,
        clusterer: Box<dyn Clusterer>,
        deformer: Box<dyn Deformer>,
        handles: usize,
        result: PathBuf,
    },
    /// Finds the map from a source to a target. The result is the map as JSON.
    Correspond {
        source: PathBuf,
        target: PathBuf,
        correspondence: Box<dyn Correspondence>,
        proximity: Option<Box<dyn Proximity>>,
        result: PathBuf,
    },
    /// Carries all poses of the source over, along a map. The results are `pose-0`, `pose-1` … in a folder.
    Transfer {
        source: PathBuf,
        target: PathBuf,
        map: PathBuf,
        transfer: Box<dyn Transfer>,
        proximity: Option<Box<dyn Proximity>>,
        result: PathBuf,
    },
    /// Finds the closest point of a mesh for each of `points`. The result is the points found.
    Closest { mesh: PathBuf, points: PathBuf, result: PathBuf },
    /// Distances along a mesh from its first handles. The result is #V distances a handle.
    Distances { mesh: PathBuf, handles: usize, result: PathBuf },
    /// Reads the mesh in a file. The result is its vertices.
    Read { format: Box<dyn Format>, file: PathBuf, result: PathBuf },
    /// Writes a mesh to a file.
    Write { mesh: PathBuf, format: Box<dyn Format>, result: PathBuf },
}

impl Job {
    /// Reads a job.
    pub fn read(file: &str) -> Result<Self, Failure> {
        Ok(serde_json::from_slice(&fs::read(file)?)?)
    }

    /// Runs the job, and tells what it took.
    pub fn run(self) -> Result<Value, Failure> {
        let mut clock = Clock::default();
        let about = self.measure(&mut clock)?;
        Ok(clock.report(about))
    }

    fn measure(self, clock: &mut Clock) -> Result<Value, Failure> {
        match self {
            Self::Make { generator, handles, mesh } => {
                let made = clock.phase("make", || generator.make())?;
                store(&made, &*handles, mesh)
            }
            Self::Import { format, file, poses, handles, mesh } => {
                let mut sequence = read(&*format, &file)?;
                for pose in poses {
                    let positions = read(&*format, &pose)?.rest.positions;
                    sequence.poses.push(Pose::new(pose.display().to_string(), positions));
                }
                store(&sequence, &*handles, mesh)
            }
            Self::Weights { mesh, weights, handles, proximity, result } => {
                let mesh = Folder(mesh);
                let (surface, points) = (mesh.surface()?, mesh.handles(handles)?);
                let graph = linked(proximity.as_deref(), &surface, clock)?;
                let bound = clock.phase("bind", || weights.bind(&surface, &points, graph.as_ref()))?;
                let chosen: Vec<usize> = (0..handles).collect();
                let found = clock.phase("solve", || bound.solve(&chosen))?;
                write_numbers(&result, found.matrix.iter().map(|w| w.to_le_bytes()))?;
                Ok(json!(found.figures))
            }
            Self::Deform { mesh, weights, clusterer, deformer, handles, result } => {
                let mesh = Folder(mesh);
                let (surface, points) = (mesh.surface()?, mesh.handles(handles)?);
                let pose = mesh.pose(0)?.ok_or("the mesh has no pose")?;
                let chosen: Vec<usize> = (0..handles).collect();
                let weights = weights.bind(&surface, &points, None)?.solve(&chosen)?;
                let regions = clusterer.bind(&surface, &[])?.cluster(&weights.matrix)?;
                let bound = clock.phase("bind", || deformer.bind(&surface))?;
                let skin = clock.phase("skin", || bound.skin(&weights, &regions))?;
                let fit = clock.phase("fit", || skin.fit(&pose))?;
                write_points(&result, &fit.positions)?;
                Ok(json!(fit.figures))
            }
            Self::Correspond { source, target, correspondence, proximity, result } => {
                let (source, target) = (Folder(source), Folder(target));
                let markers = markers(&source, &target)?;
                let (source, target) = (source.surface()?, target.surface()?);
                let graph = linked(proximity.as_deref(), &target, clock)?;
                let pair =
                    TransferPair { source: &source, target: &target, markers: &markers, proximity: graph.as_ref() };
                let map = clock.phase("correspond", || correspondence.correspond(pair))?;
                fs::write(&result, serde_json::to_vec(&map)?)?;
                Ok(json!(map.figures))
            }
            Self::Transfer { source, target, map, transfer, proximity, result } => {
                let (source, target) = (Folder(source), Folder(target));
                let (poses, markers) = (source.poses()?, markers(&source, &target)?);
                let (source, target) = (source.surface()?, target.surface()?);
                let map: TriangleMap = serde_json::from_slice(&fs::read(map)?)?;
                let graph = linked(proximity.as_deref(), &target, clock)?;
                let pair =
                    TransferPair { source: &source, target: &target, markers: &markers, proximity: graph.as_ref() };
                let wanted = &poses[..transfer.poses_wanted().min(poses.len())];
                let input = BindInput { pair, map: Some(&map), poses: wanted, work: Work::UNWATCHED };
                let bound = clock.phase("bind", || transfer.bind(input))?;
                // No lane is idle.
                let count = poses.len().next_multiple_of(bound.at_once());
                let several: Vec<&[Point3<f64>]> = poses.iter().map(Vec::as_slice).cycle().take(count).collect();
                let moved = clock.phase("frames", || bound.transfer_all(&several));
                fs::create_dir_all(&result)?;
                for (k, moved) in moved.into_iter().enumerate().take(poses.len()) {
                    write_points(&result.join(format!("pose-{k}")), &moved?.positions)?;
                }
                Ok(json!({ "frames": count }))
            }
            Self::Closest { mesh, points: file, result } => {
                let (surface, queries) = (Folder(mesh).surface()?, points(&file)?);
                let search = clock.phase("bind", || ClosestPoint::new(&surface.positions, &surface.triangles))?;
                let find = |query: &Point3<f64>| search.find(query, f64::INFINITY, |_| true).map(|found| found.point);
                let found: Option<Vec<_>> = clock.phase("find", || queries.iter().map(find).collect());
                write_points(&result, &found.ok_or("a point has no closest one")?)?;
                Ok(Value::Null)
            }
            Self::Distances { mesh, handles, result } => {
                let mesh = Folder(mesh);
                let (surface, points) = (mesh.surface()?, mesh.handles(handles)?);
                let paths = clock.phase("bind", || EdgePaths::new(&surface.positions, &surface.triangles, &[]));
                let from = |point: &SurfacePoint| paths.distances(&[point.corners(&surface)[0].0]);
                let found: Vec<Vec<f64>> = clock.phase("distances", || points.iter().map(from).collect());
                write_numbers(&result, found.iter().flatten().map(|d| d.to_le_bytes()))?;
                Ok(Value::Null)
            }
            Self::Read { format, file, result } => {
                let mesh = clock.phase("read", || read(&*format, &file))?.rest;
                write_points(&result, &mesh.positions)?;
                Ok(json!({ "polygons": mesh.polygons.len() }))
            }
            Self::Write { mesh, format, result } => {
                let surface = Folder(mesh).surface()?;
                let mesh = Mesh::from_triangles(surface.positions, &surface.triangles);
                clock.phase("write", || -> Result<(), Failure> {
                    let Some(MeshWriter::Pose(writer)) = format.writer() else {
                        return Err("the format does not write a pose a file".into());
                    };
                    let mut out = std::io::BufWriter::new(fs::File::create(&result)?);
                    writer.write(&mesh, &mesh.positions, &mut out)?;
                    Ok(std::io::Write::flush(&mut out)?)
                })?;
                Ok(Value::Null)
            }
        }
    }
}

/// The mesh in a file.
fn read(format: &dyn Format, file: &Path) -> Result<MeshSequence, Failure> {
    let input = BytesInput::new(file, fs::read(file)?);
    Ok(format.read(&input, &Selection::default())?)
}

/// Writes a mesh with handles into a folder, and tells what it is.
fn store(made: &MeshSequence, handles: &dyn Sampler, mesh: PathBuf) -> Result<Value, Failure> {
    let surface = Surface::new(&made.rest)?;
    let points = handles.sample_available(&surface)?.points;
    Folder(mesh).write(made, &surface, &points)?;
    let components = surface.components().count();
    Ok(json!({ "vertices": surface.vertex_count(), "triangles": surface.triangle_count(), "components": components }))
}

/// The graph of the components of `surface`, if one is asked for.
fn linked(
    proximity: Option<&dyn Proximity>,
    surface: &Surface,
    clock: &mut Clock,
) -> Result<Option<ProximityGraph>, Failure> {
    Ok(proximity.map(|stage| clock.phase("proximity", || stage.proximity(surface))).transpose()?)
}
