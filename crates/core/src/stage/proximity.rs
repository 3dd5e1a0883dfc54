use std::fmt::Debug;

use petgraph::graph::{NodeIndex, UnGraph};
use serde::{Deserialize, Serialize, Serializer};

use crate::{
    Error, Figures, Result,
    mesh::{Components, Surface},
    plugin::instance,
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

/// The graph of a surface's components: a node for each component, and an edge for each link between two of them.
///
/// In JSON the edges are the list `links`.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(try_from = "Unchecked")]
pub struct ProximityGraph {
    /// The components; component `c` is the node with index `c`.
    pub components: Components,
    /// The edges are sorted by the components they join.
    #[serde(rename = "links", serialize_with = "serialize_links")]
    graph: UnGraph<(), Link>,
    /// What was found.
    pub figures: Figures,
}

/// A link between two components that are to keep together.
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
    /// The graph of `links`, in any order, between `components`.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if a link does not join two of the components, smaller number first.
    pub fn new(components: Components, mut links: Vec<Link>, figures: Figures) -> Result<Self> {
        let count = components.count();
        let joins_two = |link: &Link| link.components[0] < link.components[1] && (link.components[1] as usize) < count;
        if let Some(Link { components: [a, b], .. }) = links.iter().find(|link| !joins_two(link)) {
            return Err(Error::data(
                format!("a link joins components {a} and {b}, of {count} components"),
                "give each link two components, numbered from 0, smaller number first",
            ));
        }
        links.sort_by_key(|link| link.components);
        let mut graph = nodes(count);
        for link in links {
            let [a, b] = link.components.map(NodeIndex::from);
            graph.add_edge(a, b, link);
        }
        Ok(Self { components, graph, figures })
    }

    /// The graph of a surface whose components are not tied to each other.
    pub fn unlinked(target: &Surface) -> Self {
        let components = target.components();
        Self { graph: nodes(components.count()), components, figures: Figures::default() }
    }

    /// The graph itself, for the algorithms of petgraph and its output for Graphviz.
    pub fn graph(&self) -> &UnGraph<(), Link> {
        &self.graph
    }

    /// The links, sorted by the components they join.
    pub fn links(&self) -> impl Iterator<Item = &Link> {
        self.graph.edge_weights()
    }

    /// The pairs of vertices of all links.
    pub fn pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        self.links().flat_map(|link| link.pairs.iter().copied())
    }

    /// Pairs of vertices that bridge the gaps between the components of `surface`, for distances along it; none if it is one component.
    ///
    /// They are those of the proximity `spanning_tree` with its defaults; none if that is not linked into the program.
    ///
    /// # Errors
    ///
    /// The errors of that proximity.
    pub fn bridges(surface: &Surface) -> Result<Vec<[u32; 2]>> {
        let proximity = instance::<dyn Proximity>("spanning_tree").filter(|_| surface.components().count() > 1);
        let graph = proximity.map(|proximity| proximity.proximity(surface)).transpose()?;
        Ok(graph.map_or_else(Vec::new, |graph| graph.pairs().collect()))
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

impl PartialEq for ProximityGraph {
    fn eq(&self, other: &Self) -> bool {
        self.components == other.components && self.links().eq(other.links()) && self.figures == other.figures
    }
}

/// A graph of `count` nodes without edges.
fn nodes(count: usize) -> UnGraph<(), Link> {
    let mut graph = UnGraph::default();
    (0..count).for_each(|_| _ = graph.add_node(()));
    graph
}

fn serialize_links<S: Serializer>(graph: &UnGraph<(), Link>, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_seq(graph.edge_weights())
}

/// A [`ProximityGraph`] as it is read, before its links are known to join components.
#[derive(Deserialize)]
struct Unchecked {
    components: Components,
    links: Vec<Link>,
    figures: Figures,
}

impl TryFrom<Unchecked> for ProximityGraph {
    type Error = Error;

    fn try_from(Unchecked { components, links, figures }: Unchecked) -> Result<Self> {
        Self::new(components, links, figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn link(components: [u32; 2]) -> Link {
        Link { components, distance: 0.5, in_tree: true, stiffness: 1.0, pairs: vec![components.map(|c| 3 * c)] }
    }

    fn graph(links: Vec<Link>) -> Result<ProximityGraph> {
        let components = Components::new(9, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
        ProximityGraph::new(components, links, Figures::default())
    }

    #[test]
    fn links_are_edges_in_the_order_of_their_components() {
        let graph = graph(vec![link([1, 2]), link([0, 2]), link([0, 1])]).unwrap();
        let found: Vec<_> = graph.links().map(|link| link.components).collect();
        assert_eq!(found, [[0, 1], [0, 2], [1, 2]]);
        let ends = |edge| graph.graph().edge_endpoints(edge).map(|(a, b)| [a, b].map(|node| node.index() as u32));
        let edges: Vec<_> = graph.graph().edge_indices().filter_map(ends).collect();
        assert_eq!((graph.graph().node_count(), edges), (3, found));
    }

    #[test]
    fn a_link_of_no_two_components_is_refused() {
        for ends in [[0, 3], [1, 1], [2, 1]] {
            let error = graph(vec![link(ends)]).unwrap_err().to_string();
            assert!(error.contains(&format!("components {} and {}", ends[0], ends[1])), "{error}");
        }
    }

    #[test]
    fn json_has_components_links_and_figures_and_gives_the_graph_back() {
        let graph = graph(vec![link([0, 1])]).unwrap();
        let json = r#"{"components":{"of_vertex":[0,0,0,1,1,1,2,2,2],"sizes":[3,3,3]},"links":[{"components":[0,1],"distance":0.5,"in_tree":true,"stiffness":1.0,"pairs":[[0,3]]}],"figures":{}}"#;
        assert_eq!(serde_json::to_string(&graph).unwrap(), json);
        assert_eq!(serde_json::from_str::<ProximityGraph>(json).unwrap(), graph);
        assert!(serde_json::from_str::<ProximityGraph>(&json.replace("[0,1],\"d", "[0,7],\"d")).is_err());
    }
}
