//! A chain of components: each is linked to the nearest of those before it, by their closest vertices.

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    plugin::check_ranges,
    register,
    spatial::Nearest,
    stage::{Link, Proximity, ProximityGraph},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Proximity: MyStage);

/// Links each component to the nearest of those before it in the file.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// Pairs of vertices that hold a link together.
    #[schemars(range(min = 1))]
    pub pairs: usize,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { pairs: 4 }
    }
}

#[typetag::serde(name = "my_stage")]
impl Proximity for MyStage {
    fn proximity(&self, target: &Surface) -> Result<ProximityGraph> {
        check_ranges(self)?;
        let components = target.components();
        let mut vertices = vec![Vec::new(); components.count()];
        for (v, component) in (0u32..).zip(&components.of_vertex) {
            component.iter().for_each(|&c| vertices[c as usize].push(v));
        }
        let places =
            |vertices: &[u32]| vertices.iter().map(|&v| target.positions[v as usize]).collect::<Vec<Point3<f64>>>();
        let mut links = Vec::new();
        let mut before: Vec<u32> = Vec::new();
        for (component, own) in vertices.iter().enumerate() {
            if !before.is_empty() {
                links.push(self.link(component, own, &before, &places, &components.of_vertex)?);
            }
            before.extend(own);
        }
        let mut figures = Figures::default();
        figures.set("links", links.len());
        ProximityGraph::new(components, links, figures)
    }
}

impl MyStage {
    /// The link of `component`, of the vertices `own`, to the component that has the nearest of the vertices `before`.
    fn link(
        &self,
        component: usize,
        own: &[u32],
        before: &[u32],
        places: &impl Fn(&[u32]) -> Vec<Point3<f64>>,
        of_vertex: &[Option<u32>],
    ) -> Result<Link> {
        let all = Nearest::new(&places(before))?;
        let mut found: Vec<(f64, u32, u32)> = own
            .iter()
            .zip(places(own))
            .map(|(&v, place)| {
                let (nearest, distance) = all.find(&place);
                (distance, v, before[nearest as usize])
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let other = of_vertex[found[0].2 as usize].unwrap_or_default();
        let to_other = found.iter().filter(|(_, _, by)| of_vertex[*by as usize] == Some(other));
        Ok(Link {
            // Smaller number first, which that of a component before is.
            components: [other, component as u32],
            distance: found[0].0,
            // A component has one link to those before it: these links alone are a tree.
            in_tree: true,
            stiffness: 1.0,
            pairs: to_other.take(self.pairs).map(|&(_, v, by)| [by, v]).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn two_spheres_are_linked_where_they_are_closest() {
        let surface = meshes::two_components();
        let graph = MyStage::default().proximity(&surface).unwrap();
        let [link] = graph.links().collect::<Vec<_>>()[..] else { panic!("one link") };
        let [a, b] = link.pairs[0].map(|v| surface.positions[v as usize]);
        assert!(link.components == [0, 1] && a.x > 0.5 && b.x < 2.5, "{a} {b}");
    }
}
