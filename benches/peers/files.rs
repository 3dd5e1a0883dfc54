//! Meshes as folders of bare numbers, so that no side of a comparison is timed or blamed for its reader.
//!
//! `vertices` and `pose-0`, `pose-1` … hold x, y, z of each vertex as f64; `triangles` three corners as u32; `handles` vertices as
//! u32. All are little-endian. `landmarks.json` has the named points, as triangles with barycentric coordinates.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
};

use mimesh::core::{
    mesh::{MeshSequence, Surface, SurfacePoint},
    stage::Marker,
};
use nalgebra::Point3;
use serde_json::{Map, Value, json};

/// The error of a job, to be printed.
pub type Failure = Box<dyn Error>;

/// A mesh in a folder.
pub struct Folder(pub PathBuf);

impl Folder {
    /// The mesh at rest.
    pub fn surface(&self) -> Result<Surface, Failure> {
        let corners = self.vertices_in("triangles")?;
        let triangles = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        Ok(Surface::from_triangles(points(&self.0.join("vertices"))?, triangles)?)
    }

    /// The vertices in pose `k`; `None` if there are not so many.
    pub fn pose(&self, k: usize) -> Result<Option<Vec<Point3<f64>>>, Failure> {
        let path = self.0.join(format!("pose-{k}"));
        if path.is_file() { Ok(Some(points(&path)?)) } else { Ok(None) }
    }

    /// The vertices in all poses.
    pub fn poses(&self) -> Result<Vec<Vec<Point3<f64>>>, Failure> {
        (0..).map(|k| self.pose(k)).map_while(Result::transpose).collect()
    }

    /// The first `count` handles.
    pub fn handles(&self, count: usize) -> Result<Vec<SurfacePoint>, Failure> {
        let vertices = self.vertices_in("handles")?;
        if vertices.len() < count {
            return Err(format!("{} has {} handles, not {count}", self.0.display(), vertices.len()).into());
        }
        Ok(vertices.into_iter().take(count).map(SurfacePoint::Vertex).collect())
    }

    /// The named points.
    pub fn landmarks(&self) -> Result<Map<String, Value>, Failure> {
        Ok(serde_json::from_slice(&fs::read(self.0.join("landmarks.json"))?)?)
    }

    /// Writes a mesh with its poses, and `handles`.
    pub fn write(&self, made: &MeshSequence, surface: &Surface, handles: &[SurfacePoint]) -> Result<(), Failure> {
        fs::create_dir_all(&self.0)?;
        write_points(&self.0.join("vertices"), &surface.positions)?;
        write_numbers(&self.0.join("triangles"), surface.triangles.iter().flatten().map(|v| v.to_le_bytes()))?;
        let vertices = handles.iter().map(|point| point.corners(surface)[0].0.to_le_bytes());
        write_numbers(&self.0.join("handles"), vertices)?;
        for (k, pose) in made.poses.iter().enumerate() {
            write_points(&self.0.join(format!("pose-{k}")), &surface.from_mesh(&pose.positions.get()?)?)?;
        }
        let landmarks = made.landmarks.iter().filter_map(|landmark| {
            let (triangle, barycentric) = on_triangle(surface, surface.point(landmark.point)?)?;
            Some((landmark.name.clone(), json!([triangle, barycentric])))
        });
        Ok(fs::write(self.0.join("landmarks.json"), Value::Object(landmarks.collect()).to_string())?)
    }

    fn vertices_in(&self, name: &str) -> Result<Vec<u32>, Failure> {
        let bytes = fs::read(self.0.join(name))?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|number| u32::from_le_bytes(*number)).collect())
    }
}

/// The points that have one name on both sides.
pub fn markers(source: &Folder, target: &Folder) -> Result<Vec<Marker>, Failure> {
    let (of_source, of_target) = (source.landmarks()?, target.landmarks()?);
    let pairs = of_source.into_iter().filter_map(|(name, source)| Some((of_target.get(&name)?.clone(), name, source)));
    let marker = |(target, name, source): (Value, String, Value)| -> Result<Marker, Failure> {
        let point = |value: Value| serde_json::from_value(value).map(|(t, b)| SurfacePoint::Triangle(t, b));
        Ok(Marker { name, source: point(source)?, target: point(target)? })
    };
    pairs.map(marker).collect()
}

/// A point as a place on a triangle.
fn on_triangle(surface: &Surface, point: SurfacePoint) -> Option<(u32, [f64; 3])> {
    match point {
        SurfacePoint::Triangle(triangle, barycentric) => Some((triangle, barycentric)),
        SurfacePoint::Vertex(vertex) => {
            let triangle = surface.triangles.iter().position(|t| t.contains(&vertex))?;
            let is_corner = |v: u32| f64::from(u8::from(v == vertex));
            Some((triangle as u32, surface.triangles[triangle].map(is_corner)))
        }
    }
}

/// Reads points.
pub fn points(path: &Path) -> Result<Vec<Point3<f64>>, Failure> {
    let bytes = fs::read(path)?;
    let numbers: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|number| f64::from_le_bytes(*number)).collect();
    Ok(numbers.chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2])).collect())
}

/// Writes points.
pub fn write_points(path: &Path, points: &[Point3<f64>]) -> Result<(), Failure> {
    write_numbers(path, points.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_le_bytes))
}

/// Writes numbers that are bytes already.
pub fn write_numbers<const N: usize>(path: &Path, numbers: impl Iterator<Item = [u8; N]>) -> Result<(), Failure> {
    Ok(fs::write(path, numbers.flatten().collect::<Vec<u8>>())?)
}
