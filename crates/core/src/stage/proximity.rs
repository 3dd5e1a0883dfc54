use std::fmt::Debug;

use serde::{Deserialize, Serialize};

use crate::{
    Error, Figures, Result,
    mesh::{Components, Surface},
};

/// Finds which components of a target lie close together, and by which vertices.
///
/// # Contract
///
/// - the graph joins all components, in whatever number of steps;
/// - pairs join vertices of the two components of their link;
/// - equal surfaces give equal graphs, on one thread or many.
#[typetag::serde(tag = "type")]
pub trait Proximity: Debug + Send + Sync {
    /// The graph of the components of `target` at rest.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for settings out of range, [`Error::Data`] for components that do not exist.
    fn proximity(&self, target: &Surface) -> Result<ProximityGraph>;
}

crate::stage_kind!(Proximity, "proximity");

/// Components as nodes, and links between those that lie close together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProximityGraph {
    /// The components.
    pub components: Components,
    /// Links, sorted by the components they join.
    pub links: Vec<Link>,
    /// What was found.
    pub figures: Figures,
}

/// Two components that are to keep together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// The two components, smaller number first.
    pub components: [u32; 2],
    /// The shortest distance between vertices of the two, in the unit of the file.
    pub distance: f64,
    /// Whether the link belongs to the minimum spanning tree.
    pub in_tree: bool,
    /// How strongly it holds; 1 for an ordinary link.
    pub stiffness: f64,
    /// Pairs of vertices that are to keep together, one of each component, closest first.
    pub pairs: Vec<[u32; 2]>,
}

impl ProximityGraph {
    /// The graph of a surface whose components are not tied to each other.
    pub fn unlinked(target: &Surface) -> Self {
        Self { components: target.components(), links: vec![], figures: Figures::default() }
    }

    /// Pairs of vertices of all links.
    pub fn pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        self.links.iter().flat_map(|link| link.pairs.iter().copied())
    }

    /// Checks that the graph belongs to `target`.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if it has another number of vertices.
    pub fn check(&self, target: &Surface) -> Result<()> {
        Error::check_shape("proximity: vertices of the target", target.vertex_count(), self.components.of_vertex.len())
    }
}
