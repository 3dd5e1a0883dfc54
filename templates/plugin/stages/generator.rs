//! A tube that bends.
//!
//! Of radius 1 about the y axis, closed by fans at both ends. In pose k of n its middle line is an arc of angle k/n · `bend`.

use mimesh_core::{
    Result,
    mesh::{Landmark, Mesh, MeshPoint, MeshSequence, Pose},
    plugin::check_ranges,
    register,
    stage::Generator,
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Generator: MyStage);

/// A tube that bends.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// Vertices around it.
    #[schemars(range(min = 3, max = 1000))]
    pub around: usize,
    /// Rings of quads along it.
    #[schemars(range(min = 1, max = 10000))]
    pub along: usize,
    /// Its length; its radius is 1.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub length: f64,
    /// The angle between its ends in the last pose, in degrees.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub bend: f64,
    /// Number of poses.
    #[schemars(range(min = 1, max = 1000))]
    pub frames: usize,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { around: 12, along: 20, length: 8.0, bend: 90.0, frames: 4 }
    }
}

#[typetag::serde(name = "my_stage")]
impl Generator for MyStage {
    fn make(&self) -> Result<MeshSequence> {
        check_ranges(self)?;
        let positions = self.positions();
        let polygons = self.polygons().iter().map(|corners| &corners[..]).collect();
        let rest = Mesh { positions: positions.clone(), polygons, ..Mesh::default() };
        let pose = |k: usize| {
            let angle = self.bend.to_radians() * k as f64 / self.frames as f64;
            let positions = positions.iter().map(|p| self.bent(p, angle)).collect();
            Pose::new(format!("{k:02}"), positions)
        };
        let landmark = |name: &str, v| Landmark { name: name.into(), point: MeshPoint::Vertex(v) };
        Ok(MeshSequence {
            rest,
            poses: (1..=self.frames).map(pose).collect(),
            landmarks: vec![landmark("bottom", 0), landmark("top", 1)],
            ..MeshSequence::default()
        })
    }
}

impl MyStage {
    /// The middles of both ends, then ring by ring.
    fn positions(&self) -> Vec<Point3<f64>> {
        let mut positions = vec![Point3::origin(), Point3::new(0.0, self.length, 0.0)];
        for ring in 0..=self.along {
            let y = self.length * ring as f64 / self.along as f64;
            positions.extend((0..self.around).map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / self.around as f64).sin_cos();
                Point3::new(sin, y, cos)
            }));
        }
        positions
    }

    /// Counter-clockwise seen from outside.
    fn polygons(&self) -> Vec<Vec<u32>> {
        let vertex = |ring: usize, k: usize| (2 + ring * self.around + k % self.around) as u32;
        let mut polygons = Vec::new();
        for k in 0..self.around {
            polygons.push(vec![0, vertex(0, k + 1), vertex(0, k)]);
            polygons.push(vec![1, vertex(self.along, k), vertex(self.along, k + 1)]);
            let side =
                |ring: usize| vec![vertex(ring, k), vertex(ring, k + 1), vertex(ring + 1, k + 1), vertex(ring + 1, k)];
            polygons.extend((0..self.along).map(side));
        }
        polygons
    }

    /// Where `p` is when the middle line is an arc of `angle` radians towards +x.
    fn bent(&self, p: &Point3<f64>, angle: f64) -> Point3<f64> {
        if angle == 0.0 {
            return *p;
        }
        let radius = self.length / angle;
        let (sin, cos) = (p.y / radius).sin_cos();
        Point3::new(radius - (radius - p.x) * cos, (radius - p.x) * sin, p.z)
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::mesh::Statistics;

    use super::*;

    #[test]
    fn it_is_closed_faces_outwards_and_keeps_the_length_of_its_middle() {
        let tube = MyStage::default();
        let made = tube.make().unwrap();
        let statistics = Statistics::new(&made.rest).unwrap();
        assert!(statistics.boundary_edges == 0 && statistics.volume.unwrap() > 0.0);
        // The top of an arc of a quarter circle of radius r is at (r, r).
        let (top, radius) = (made.poses[3].positions.get().unwrap()[1], 8.0 / std::f64::consts::FRAC_PI_2);
        assert!((top - Point3::new(radius, radius, 0.0)).norm() < 1e-12, "{top}");
    }
}
