//! The components of a mesh and the distances between them, as `inspect --components` and `--graphviz` print them.

use std::fmt::Write as _;

use mimesh_core::{
    Result,
    mesh::{Mesh, Surface},
    plugin::instances,
    stage::{Link, Proximity, ProximityGraph},
};
use mimesh_pipeline::text::{number, thousands};
use petgraph::{
    dot::{Config, Dot},
    graph::{EdgeReference, NodeIndex},
};
use serde_json::{Value, json};

/// The components of a mesh. The first registered proximity links them, with its default settings.
pub struct ComponentGraph {
    names: Vec<String>,
    sizes: Vec<usize>,
    graph: ProximityGraph,
}

impl ComponentGraph {
    /// Finds the components of `mesh` and their links.
    ///
    /// # Errors
    ///
    /// Those of [`Mesh::validate`] and of the proximity.
    pub fn new(mesh: &Mesh) -> Result<Self> {
        let surface = Surface::new(mesh)?;
        let graph = match instances::<dyn Proximity>().first() {
            Some((_, proximity)) => proximity.proximity(&surface)?,
            None => ProximityGraph::unlinked(&surface),
        };
        let components = &graph.components;
        let mut names = vec![String::new(); components.count()];
        for (t, &part) in surface.triangles.iter().zip(&surface.part_of) {
            if let Some(c) = components.of_vertex[t[0] as usize]
                && names[c as usize].is_empty()
            {
                names[c as usize].clone_from(&surface.part_names[part as usize]);
            }
        }
        Ok(Self { names, sizes: components.sizes.clone(), graph })
    }

    /// A table with a line for each component: number, name, vertices, and the components that it is linked to.
    pub fn table(&self) -> String {
        let mut text =
            String::from("  number  vertices  name, and linked components with their distance (* in the tree)\n");
        for (c, (name, size)) in self.names.iter().zip(&self.sizes).enumerate() {
            let links = self.graph.links().filter(|link| link.components.contains(&(c as u32)));
            let links: Vec<_> = links.map(|link| link_text(link, c as u32)).collect();
            let name = if name.is_empty() { "-" } else { name };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  {c:>6}  {:>8}  {name}: {}", thousands(*size), links.join(", "));
        }
        text
    }

    /// The graph for Graphviz. Edges of the tree are solid, others dashed; labels give their distance.
    pub fn graphviz(&self) -> String {
        let content = [Config::GraphContentOnly, Config::NodeNoLabel, Config::EdgeNoLabel];
        let node = |_, (node, ()): (NodeIndex, &())| self.node_attributes(node.index());
        let edge = |_, edge: EdgeReference<'_, Link>| edge_attributes(edge.weight());
        let dot = Dot::with_attr_getters(self.graph.graph(), &content, &edge, &node);
        format!("graph components {{\n    node [ shape=box ]\n{dot:?}}}\n")
    }

    fn node_attributes(&self, component: usize) -> String {
        let label = format!("{component} {}", self.names[component]);
        let label = label.trim_end().replace('\\', "\\\\").replace('"', "\\\"");
        format!("label=\"{label}\\n{} vertices\" ", thousands(self.sizes[component]))
    }

    /// The components and the links as JSON.
    pub fn json(&self) -> Value {
        let component =
            |(c, (name, size)): (usize, (&String, &usize))| json!({ "number": c, "name": name, "vertices": size });
        let link = |link: &Link| {
            json!({
                "components": link.components, "distance": link.distance, "in_tree": link.in_tree,
                "pairs": link.pairs.len(),
            })
        };
        json!({
            "components": self.names.iter().zip(&self.sizes).enumerate().map(component).collect::<Vec<_>>(),
            "links": self.graph.links().map(link).collect::<Vec<_>>(),
        })
    }
}

/// The component that `link` links to `component`, with the distance; `*` marks links of the tree.
fn link_text(link: &Link, component: u32) -> String {
    let [a, b] = link.components;
    let other = if a == component { b } else { a };
    format!("{other}{} {}", if link.in_tree { "*" } else { "" }, number(link.distance))
}

fn edge_attributes(link: &Link) -> String {
    let style = if link.in_tree { "solid" } else { "dashed" };
    format!("label=\"{}\" style={style} ", number(link.distance))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::core::{Figures, mesh::Components};

    /// The attributes of a statement `subject [ key=value key="value" ]`.
    fn attributes<'a>(statement: &'a str, subject: &str) -> BTreeMap<&'a str, &'a str> {
        let list = statement.trim().strip_prefix(subject).and_then(|rest| rest.trim().strip_prefix('['));
        let mut list = list.and_then(|rest| rest.strip_suffix(']')).expect(statement).trim();
        let mut attributes = BTreeMap::new();
        while let Some((key, rest)) = list.split_once('=') {
            let is_end = |&(at, c): &(usize, char)| c == '"' && at > 0 && !rest[..at].ends_with('\\');
            let end = match rest.starts_with('"') {
                true => rest.char_indices().find(is_end).expect("a closing quote").0 + 1,
                false => rest.find(' ').unwrap_or(rest.len()),
            };
            attributes.insert(key, rest[..end].trim_matches('"'));
            list = rest[end..].trim();
        }
        assert_eq!(list, "", "{statement}");
        attributes
    }

    #[test]
    fn graphviz_has_a_statement_for_each_component_and_each_link() {
        let components = Components::new(9, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
        let link =
            |components, distance, in_tree| Link { components, distance, in_tree, stiffness: 1.0, pairs: vec![] };
        let links = vec![link([0, 1], 0.5, true), link([1, 2], 2.0, false)];
        let names = ["head", "", r#"the "jaw""#].map(String::from).to_vec();
        let sizes = components.sizes.clone();
        let graph = ProximityGraph::new(components, links, Figures::default()).unwrap();
        let text = ComponentGraph { names, sizes, graph }.graphviz();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!((lines[0], lines[7], lines.len()), ("graph components {", "}", 8), "{text}");
        assert_eq!(attributes(lines[1], "node")["shape"], "box");
        assert_eq!(attributes(lines[2], "0")["label"], r"0 head\n3 vertices");
        assert_eq!(attributes(lines[3], "1")["label"], r"1\n3 vertices");
        assert_eq!(attributes(lines[4], "2")["label"], r#"2 the \"jaw\"\n3 vertices"#);
        assert_eq!(attributes(lines[5], "0 -- 1"), BTreeMap::from([("label", "0.5000"), ("style", "solid")]));
        assert_eq!(attributes(lines[6], "1 -- 2"), BTreeMap::from([("label", "2"), ("style", "dashed")]));
    }
}
