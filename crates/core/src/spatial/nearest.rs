use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Point3;

use crate::{Error, Result};

/// Finds nearest neighbours among points, by a k-d tree.
pub struct Nearest {
    tree: ImmutableKdTree<f64, 3>,
}

impl Nearest {
    /// Prepares to search `points`, which must be finite.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if there is no point.
    pub fn new(points: &[Point3<f64>]) -> Result<Self> {
        let entries: Vec<[f64; 3]> = points.iter().map(|p| [p.x, p.y, p.z]).collect();
        if entries.is_empty() {
            return Err(Error::data("no points to search", "give a mesh with vertices"));
        }
        let tree = ImmutableKdTree::new_from_slice(&entries)
            .map_err(|error| Error::Other(format!("k-d tree: {error:?}").into()))?;
        Ok(Self { tree })
    }

    /// The index of the nearest point and its distance.
    pub fn find(&self, query: &Point3<f64>) -> (u32, f64) {
        let found = self.tree.query(&[query.x, query.y, query.z]).nearest_one::<SquaredEuclidean<f64>>().execute();
        (found.item, found.distance.sqrt())
    }
}
