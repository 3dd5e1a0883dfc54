//! Points whose motions differ most.
//!
//! Two points are as far apart as the root mean square, over the rest and all poses, of the distance between them. The first
//! point is the one farthest from the mean; then, again and again, the one farthest from those before is added. The error is the
//! mean distance of all vertices to the nearest point, in that sense, relative to the diagonal.

use mimesh_core::{
    Error, Figures, Result,
    mesh::{SurfacePoint, check_finite},
    plugin::check_ranges,
    register,
    stage::{ChoiceStep, ChoiceWatch, Chosen, KeyPoints, KeyPointsInput},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(KeyPoints: MyStage);

/// Points whose motions differ most, each the farthest from those before.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// Number of points; fewer, where the surface has fewer vertices.
    #[schemars(range(min = 1))]
    pub count: usize,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { count: 12 }
    }
}

#[typetag::serde(name = "my_stage")]
impl KeyPoints for MyStage {
    fn choose(&self, input: KeyPointsInput<'_>, watch: &dyn ChoiceWatch) -> Result<Chosen> {
        check_ranges(self)?;
        let KeyPointsInput { source, poses, start } = input;
        if poses.is_empty() {
            return Err(Error::data("no poses to choose key points for", "give the source poses"));
        }
        for pose in poses {
            Error::check_shape("vertices of a pose (#V)", source.vertex_count(), pose.len())?;
            check_finite(pose)?;
        }
        let exists = |point: &SurfacePoint| match *point {
            SurfacePoint::Vertex(v) => (v as usize) < source.vertex_count(),
            SurfacePoint::Triangle(t, _) => (t as usize) < source.triangle_count(),
        };
        if let Some(point) = start.iter().find(|point| !exists(point)) {
            let hint = "start from points that were chosen on this mesh";
            return Err(Error::data(format!("there is no point {point:?} to start from"), hint));
        }
        let mut used = vec![false; source.vertex_count()];
        source.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let all: Vec<&[Point3<f64>]> =
            std::iter::once(&source.positions[..]).chain(poses.iter().map(|pose| &pose[..])).collect();
        // In all poses, the vertex to a point that is there at the places `to`.
        let distance = |v: usize, to: &[Point3<f64>]| {
            let sum: f64 = all.iter().zip(to).map(|(at, to)| (at[v] - to).norm_squared()).sum();
            (sum / all.len() as f64).sqrt()
        };
        let farthest = |distances: &[f64]| {
            let vertices = (0..distances.len()).filter(|&v| used[v]);
            vertices.reduce(|best, v| if distances[v] > distances[best] { v } else { best })
        };
        let middle: Vec<_> = all.iter().map(|at| nalgebra::Point3::from(mean(at))).collect();
        let from_middle: Vec<f64> = (0..used.len()).map(|v| distance(v, &middle)).collect();

        let mut nearest = vec![f64::INFINITY; used.len()];
        let mut chosen = Chosen { points: vec![], steps: vec![], figures: Figures::default() };
        let mut waiting = start.iter().copied();
        loop {
            let point = match waiting.next() {
                Some(point) => point,
                None if chosen.points.len() >= self.count || watch.is_interrupted() => break,
                None => {
                    let distances = if chosen.points.is_empty() { &from_middle } else { &nearest };
                    match farthest(distances).filter(|&v| distances[v] > 0.0) {
                        Some(v) => SurfacePoint::Vertex(v as u32),
                        None => break,
                    }
                }
            };
            let places: Vec<_> = all.iter().map(|at| point.position(source, at)).collect();
            nearest.iter_mut().enumerate().for_each(|(v, d)| *d = d.min(distance(v, &places)));
            chosen.points.push(point);
            let error = nearest.iter().sum::<f64>() / nearest.len() as f64 / source.diagonal();
            let step = ChoiceStep { points: chosen.points.clone(), error, exchanged: false };
            watch.step(&step);
            chosen.steps.push(step);
        }
        Ok(chosen)
    }
}

fn mean(points: &[Point3<f64>]) -> nalgebra::Vector3<f64> {
    points.iter().map(|p| p.coords).sum::<nalgebra::Vector3<f64>>() / points.len() as f64
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn the_part_that_moves_gets_the_first_point() {
        let bar = meshes::bar([8, 1, 1], [4.0, 1.0, 1.0]);
        // The end at x = 2 is lifted far.
        let lifted: Vec<_> =
            bar.positions.iter().map(|p| if p.x > 1.5 { p + nalgebra::Vector3::y() * 50.0 } else { *p }).collect();
        let input = KeyPointsInput { source: &bar, poses: &[lifted], start: &[] };
        let chosen = MyStage { count: 1 }.choose(input, &()).unwrap();
        assert!(chosen.points[0].position(&bar, &bar.positions).x > 1.5);
    }
}
