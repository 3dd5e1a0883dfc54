//! The components of a mesh and how they lie to each other, as `inspect --components` and `--graphviz` print them.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::core::{
    Result,
    mesh::{Mesh, Surface},
    plugin::instances,
    stage::{Proximity, ProximityGraph},
};
use crate::text::{number, thousands};

/// The components of one mesh, linked by the first registered proximity with its defaults.
pub struct ComponentGraph {
    names: Vec<String>,
    sizes: Vec<usize>,
    graph: ProximityGraph,
}

impl ComponentGraph {
    /// Looks at `mesh`.
    ///
    /// # Errors
    ///
    /// As [`Mesh::validate`], or what the proximity refuses.
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

    /// A line a component: number, name, vertices, and the components it is linked to.
    pub fn table(&self) -> String {
        let mut text =
            String::from("  number  vertices  name, and linked components with their distance (* in the tree)\n");
        for (c, (name, size)) in self.names.iter().zip(&self.sizes).enumerate() {
            let links = self.graph.links.iter().filter(|link| link.components.contains(&(c as u32)));
            let told = links.map(|link| {
                let other = if link.components[0] as usize == c { link.components[1] } else { link.components[0] };
                format!("{other}{} {}", if link.in_tree { "*" } else { "" }, number(link.distance))
            });
            let told: Vec<_> = told.collect();
            let name = if name.is_empty() { "-" } else { name };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  {c:>6}  {:>8}  {name}: {}", thousands(*size), told.join(", "));
        }
        text
    }

    /// The graph for Graphviz: tree edges solid, others dashed, labelled with their distance.
    pub fn graphviz(&self) -> String {
        let mut text = String::from("graph components {\n  node [shape=box];\n");
        for (c, (name, size)) in self.names.iter().zip(&self.sizes).enumerate() {
            let label = format!("{c} {name}").trim_end().replace('\\', "\\\\").replace('"', "\\\"");
            let _ = writeln!(text, "  {c} [label=\"{label}\\n{} vertices\"];", thousands(*size));
        }
        for link in &self.graph.links {
            let [a, b] = link.components;
            let style = if link.in_tree { "solid" } else { "dashed" };
            let _ = writeln!(text, "  {a} -- {b} [label=\"{}\", style={style}];", number(link.distance));
        }
        text + "}\n"
    }

    /// The same as JSON.
    pub fn json(&self) -> Value {
        let component =
            |(c, (name, size)): (usize, (&String, &usize))| json!({ "number": c, "name": name, "vertices": size });
        let link = |link: &crate::core::stage::Link| {
            json!({
                "components": link.components, "distance": link.distance, "in_tree": link.in_tree,
                "pairs": link.pairs.len(),
            })
        };
        json!({
            "components": self.names.iter().zip(&self.sizes).enumerate().map(component).collect::<Vec<_>>(),
            "links": self.graph.links.iter().map(link).collect::<Vec<_>>(),
        })
    }
}
