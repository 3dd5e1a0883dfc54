use serde::{Deserialize, Serialize};

use super::ProximityGraph;
use crate::{
    Error, Result,
    mesh::{Surface, SurfacePoint},
};

/// The two rest surfaces of a transfer, and the points that the user says correspond.
#[derive(Clone, Copy, Debug)]
pub struct TransferPair<'a> {
    /// The surface that gives its motion.
    pub source: &'a Surface,
    /// The surface that takes the motion.
    pub target: &'a Surface,
    /// Pairs of corresponding points; empty if none were given.
    pub markers: &'a [Marker],
    /// How the components of the target lie to each other; `None` if nothing is known of it.
    pub proximity: Option<&'a ProximityGraph>,
}

/// A point of the source and the corresponding point of the target.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Marker {
    /// A name for messages: the user's, or the marker's number in its file.
    pub name: String,
    /// The point on the source surface.
    pub source: SurfacePoint,
    /// The point on the target surface.
    pub target: SurfacePoint,
}

impl TransferPair<'_> {
    /// Checks that markers exist on both surfaces and that no two share a point on either side.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] that names the marker, or both markers.
    pub fn check_markers(&self) -> Result<()> {
        for (side, surface) in [("source", self.source), ("target", self.target)] {
            let mut seen = std::collections::HashMap::new();
            for marker in self.markers {
                let point = if side == "source" { marker.source } else { marker.target };
                check_on_surface(&marker.name, side, point, surface)?;
                let key = point.position(surface, &surface.positions).coords.map(f64::to_bits);
                if let Some(other) = seen.insert((key.x, key.y, key.z), &marker.name) {
                    return Err(Error::data(
                        format!("markers {other} and {} lie on the same point of the {side}", marker.name),
                        "remove one of the two; a point can have one partner only",
                    ));
                }
            }
        }
        Ok(())
    }
}

fn check_on_surface(name: &str, side: &str, point: SurfacePoint, surface: &Surface) -> Result<()> {
    let (what, index, count) = match point {
        SurfacePoint::Vertex(vertex) => ("vertex", vertex, surface.vertex_count()),
        SurfacePoint::Triangle(triangle, _) => ("triangle", triangle, surface.triangle_count()),
    };
    if (index as usize) < count {
        if what == "vertex" && !surface.triangles.iter().flatten().any(|&v| v == index) {
            return Err(Error::data(
                format!("marker {name}: vertex {index} of the {side} belongs to no polygon"),
                "move the marker to a vertex of the surface",
            ));
        }
        return Ok(());
    }
    Err(Error::data(
        format!("marker {name}: the {side} has no {what} {index}: expected 0 to {}", count - 1),
        "were source and target swapped, the indices counted from 1, or the mesh changed since the markers were made?",
    ))
}
