use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Point3;

use crate::{Error, Result};

/// Finds nearest neighbours among points, by a k-d tree.
pub struct Nearest {
    tree: ImmutableKdTree<f64, 3>,
    count: usize,
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
        Ok(Self { tree, count: entries.len() })
    }

    /// The index of the nearest point and its distance.
    pub fn find(&self, query: &Point3<f64>) -> (u32, f64) {
        let found = self.tree.query(&[query.x, query.y, query.z]).nearest_one::<SquaredEuclidean<f64>>().execute();
        (found.item, found.distance.sqrt())
    }

    /// The `count` nearest points (all, if there are fewer) with their distances, nearest first.
    pub fn find_many(&self, query: &Point3<f64>, count: usize) -> Vec<(u32, f64)> {
        let Some(count) = NonZero::new(count.min(self.count)) else { return vec![] };
        let query = [query.x, query.y, query.z];
        let found = self.tree.query(&query).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        let mut found: Vec<_> = found.into_iter().map(|n| (n.item, n.distance.sqrt())).collect();
        // Ties come in no stated order.
        found.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        found
    }
}
