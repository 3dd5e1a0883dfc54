//! The parts of a surface that points can be put on.

use mimesh_core::{
    Error, Result,
    mesh::{Components, Surface},
    operators::is_degenerate,
};

/// Triangles with area, their vertices, and the components these belong to.
pub struct Ground {
    /// Triangles with area.
    pub triangles: Vec<u32>,
    /// Vertices of such triangles, in ascending order.
    pub vertices: Vec<u32>,
    /// Number of components that have such triangles.
    pub component_count: usize,
    components: Components,
}

impl Ground {
    /// Looks at `surface`.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if no triangle has an area.
    pub fn new(surface: &Surface) -> Result<Self> {
        let has_area = |t: &u32| !is_degenerate(&surface.corners(&surface.positions, *t as usize));
        let triangles: Vec<u32> = (0..surface.triangle_count() as u32).filter(has_area).collect();
        if triangles.is_empty() {
            return Err(Error::data(
                "no triangle has an area to put points on",
                "export the mesh again; all its triangles are points or lines",
            ));
        }
        let mut vertices: Vec<u32> = triangles.iter().flat_map(|&t| surface.triangles[t as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let components = surface.components();
        let mut with_area: Vec<_> = vertices.iter().map(|&v| components.of_vertex[v as usize]).collect();
        with_area.sort_unstable();
        with_area.dedup();
        Ok(Self { component_count: with_area.len(), triangles, vertices, components })
    }

    /// The component of a vertex of a triangle.
    pub fn component(&self, vertex: u32) -> usize {
        self.components.of_vertex[vertex as usize].map_or(0, |c| c as usize)
    }

    /// Number of components of the surface, with area or not.
    pub fn all_components(&self) -> usize {
        self.components.count()
    }

    /// Checks that `count` points can be put at different vertices.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if there are too few vertices.
    pub fn check(&self, count: usize) -> Result<()> {
        if count > self.vertices.len() {
            return Err(too_few(count, self.vertices.len()));
        }
        Ok(())
    }
}

/// The error of asking for more points than there are places.
pub fn too_few(count: usize, places: usize) -> Error {
    Error::data(
        format!("{count} points were asked for, and the surface has only {places} vertices at different places"),
        "set a smaller `count`",
    )
}
