//! The vertices of each component, with what is asked of them in a search for close components.

use mimesh_core::{
    Result,
    mesh::{Components, Surface, bounding_box},
    spatial::Nearest,
};
use nalgebra::Point3;

/// One component.
pub struct Part {
    /// Its vertices, of the surface.
    pub vertices: Vec<u32>,
    positions: Vec<Point3<f64>>,
    nearest: Nearest,
    /// The corners of its bounding box.
    pub low: Point3<f64>,
    pub high: Point3<f64>,
    /// Its longest edge.
    pub longest_edge: f64,
}

impl Part {
    pub fn all(target: &Surface, components: &Components) -> Result<Vec<Self>> {
        let mut vertices = vec![Vec::new(); components.count()];
        for (vertex, component) in components.of_vertex.iter().enumerate() {
            if let Some(component) = component {
                vertices[*component as usize].push(vertex as u32);
            }
        }
        let mut longest = vec![0.0f64; components.count()];
        for t in &target.triangles {
            let [a, b, c] = t.map(|v| target.positions[v as usize]);
            if let Some(component) = components.of_vertex[t[0] as usize] {
                let edge = (b - a).norm().max((c - b).norm()).max((a - c).norm());
                longest[component as usize] = longest[component as usize].max(edge);
            }
        }
        let part = |(vertices, longest_edge): (Vec<u32>, f64)| {
            let positions: Vec<_> = vertices.iter().map(|&v| target.positions[v as usize]).collect();
            let (low, high) = bounding_box(&positions);
            Ok(Self { nearest: Nearest::new(&positions)?, vertices, positions, low, high, longest_edge })
        };
        vertices.into_iter().zip(longest).map(part).collect()
    }

    /// A lower bound of the distance to `other`: that of the bounding boxes, less what rounding may add to it.
    pub fn box_distance(&self, other: &Self) -> f64 {
        let gap = (self.low - other.high).sup(&(other.low - self.high));
        gap.map(|x| x.max(0.0)).norm() * (1.0 - 4.0 * f64::EPSILON)
    }

    /// A lower bound of the distance of its vertices to `point`, as [`box_distance`](Self::box_distance) is.
    fn distance_to_box(&self, point: &Point3<f64>) -> f64 {
        let gap = (self.low - point).sup(&(point - self.high));
        gap.map(|x| x.max(0.0)).norm() * (1.0 - 4.0 * f64::EPSILON)
    }

    /// The shortest distance between vertices of the two.
    pub fn distance(&self, other: &Self) -> f64 {
        let (few, many) = if self.vertices.len() <= other.vertices.len() { (self, other) } else { (other, self) };
        let nearer = |nearest: f64, p| {
            if many.distance_to_box(p) >= nearest { nearest } else { nearest.min(many.nearest.find(p).1) }
        };
        few.positions.iter().fold(f64::INFINITY, nearer)
    }

    /// For each vertex nearer to `other` than `limit` its nearest vertex there: distance, own vertex, the other's.
    pub fn near(&self, other: &Self, limit: f64) -> Vec<(f64, u32, u32)> {
        let find = |(p, &v): (&Point3<f64>, &u32)| {
            if other.distance_to_box(p) > limit {
                return None;
            }
            let (index, distance) = other.nearest.find(p);
            (distance <= limit).then(|| (distance, v, other.vertices[index as usize]))
        };
        self.positions.iter().zip(&self.vertices).filter_map(find).collect()
    }
}
