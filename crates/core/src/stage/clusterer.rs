use std::fmt::Debug;

use nalgebra::{DMatrix, Point3};

use crate::{Error, Figures, Result, mesh::Surface};

/// Divides a surface into regions that move about rigidly.
///
/// [`bind`](Self::bind) does once what depends on the surface and its poses; the [`BoundClusterer`] then serves any weights.
///
/// # Contract
///
/// `testkit::contracts` holds implementations to this:
/// - every vertex has a region, none is empty, and there are at most as many as handles unless a setting asks for another number;
/// - equal inputs give equal regions, on one thread or many.
#[typetag::serde(tag = "type")]
pub trait Clusterer: Debug + Send + Sync {
    /// Prepares for weights over `surface` with its `poses` (each #V).
    ///
    /// # Errors
    ///
    /// [`Error::Setting`](crate::Error::Setting) for settings out of range, [`Error::Shape`](crate::Error::Shape) for poses of
    /// another mesh.
    fn bind(&self, surface: &Surface, poses: &[Vec<Point3<f64>>]) -> Result<Box<dyn BoundClusterer>>;
}

/// A clusterer bound to a surface and its poses.
pub trait BoundClusterer: Debug + Send + Sync {
    /// The regions for W (#V × #H), at most #H of them unless a setting asks for another number.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`](crate::Error::Shape) if W has another number of rows.
    fn cluster(&self, weights: &DMatrix<f64>) -> Result<Regions>;
}

crate::stage_kind!(Clusterer, "clusterer");

/// The region of each vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    /// #V numbers below [`count`](Self::count).
    pub of_vertex: Vec<u32>,
    /// Number of regions.
    pub count: usize,
    /// The report of the clustering.
    pub figures: Figures,
}

impl Regions {
    /// Checks that every one of `vertices` vertices has a region.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if they are regions of another surface, [`Error::Data`] if a region's number is out of range.
    pub fn check(&self, vertices: usize) -> Result<()> {
        Error::check_shape("vertices with a region (#V)", vertices, self.of_vertex.len())?;
        match self.of_vertex.iter().position(|&region| region as usize >= self.count) {
            None => Ok(()),
            Some(vertex) => Err(Error::data(
                format!("vertex {vertex} (from 0) is in region {} of {}", self.of_vertex[vertex], self.count),
                "this is a mistake in the clusterer that made the regions",
            )),
        }
    }
}
