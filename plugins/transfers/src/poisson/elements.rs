//! The triangles of a system of deformation gradients.

use mimesh_core::{mesh::Surface, operators::Gradient};
use nalgebra::Vector3;

/// How strongly the edges of triangles without area are held, in units of cotangent weight: enough to tie a vertex that has
/// no other triangle, too little to be felt by one that has.
const DEGENERATE_WEIGHT: f64 = 1e-4;

/// The pairs of corners of a triangle.
pub(super) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// A row or an entry that a held vertex does not have.
pub(super) const NONE: u32 = u32::MAX;

/// A triangle of the surface, in terms of its edges e₁ and e₂ from its first corner to the others.
///
/// With g₁ and g₂ the gradients of these corners, F P = ẽ₁ g₁ᵀ + ẽ₂ g₂ᵀ for posed edges ẽ, and products of gradients are those of
/// the 2 × 2 matrix gᵢ · gⱼ. It stands for a triangle without area too, whose edges are held a little.
#[derive(Clone, Debug)]
pub(super) struct Element {
    /// e₁ and e₂ at rest.
    pub edges: [Vector3<f64>; 2],
    /// g₁ · g₁, g₁ · g₂ and g₂ · g₂.
    pub products: [f64; 3],
    /// ‖F P‖² is the sum of (a ẽ₁ + b ẽ₂)² and (c ẽ₂)² over the coordinates; a, b and c.
    pub norm: [f64; 3],
    /// w_t, or [`DEGENERATE_WEIGHT`].
    pub weight: f64,
    /// Its number.
    pub triangle: u32,
    /// Whether it has an area and is reweighted.
    pub has_area: bool,
    /// The rows of its corners in the system; that after the last one where a corner is held.
    pub rows: [u32; 3],
    /// The numbers of the entries of [`PAIRS`]; [`NONE`] where a corner is held.
    pub entries: [u32; 6],
}

impl Element {
    fn new(target: &Surface, triangle: usize, weight: impl Fn(f64) -> f64) -> Self {
        let points = target.corners(&target.positions, triangle);
        let triangle = triangle as u32;
        let edges = [points[1] - points[0], points[2] - points[0]];
        let (rows, entries) = ([NONE; 3], [NONE; 6]);
        let Some(gradient) = Gradient::new(&points) else {
            // Σ over the three edges of the squared difference from where the field has them.
            let products = [2.0, -1.0, 2.0];
            let (norm, weight) = ([0.0; 3], DEGENERATE_WEIGHT);
            return Self { edges, products, norm, weight, triangle, has_area: false, rows, entries };
        };
        let [first, second] = [gradient.of_corners.column(1), gradient.of_corners.column(2)];
        let products = [first.norm_squared(), first.dot(&second), second.norm_squared()];
        // g₁ is at right angles to e₂, along which g₂ is 1 / ‖e₂‖.
        let norm = [first.norm(), products[1] / first.norm(), 1.0 / edges[1].norm()];
        Self { edges, products, norm, weight: weight(gradient.area), triangle, has_area: true, rows, entries }
    }

    /// gᵢ · gⱼ of the [`PAIRS`].
    pub fn stiffness(&self) -> [f64; 6] {
        let [one, mixed, two] = self.products;
        [one + 2.0 * mixed + two, one, two, -(one + mixed), mixed, -(mixed + two)]
    }
}

/// All triangles of `target`; `weight` gives w_t from an area.
pub(super) fn all(target: &Surface, weight: impl Fn(f64) -> f64) -> Vec<Element> {
    let areas = |t: usize| Gradient::new(&target.corners(&target.positions, t)).map_or(0.0, |g| g.area);
    let mut elements: Vec<_> = (0..target.triangle_count()).map(|t| Element::new(target, t, &weight)).collect();
    // Relative to cotangents, so that triangles without area have the same effect whatever the weights.
    let area: f64 = (0..elements.len()).map(areas).sum();
    let with_area = || elements.iter().filter(|e| e.has_area);
    let scale = area / with_area().map(|e| e.weight).sum::<f64>();
    elements.iter_mut().filter(|e| e.has_area).for_each(|e| e.weight *= scale);
    elements
}

/// Gives `elements` their rows and entries, and sorts them by rows, so that a pass goes through memory in order; `numbers` has those
/// of vertices in the matrix.
pub(super) fn place(
    elements: &mut [Element],
    triangles: &[[u32; 3]],
    numbers: &[Option<u32>],
    row: impl Fn(u32) -> u32,
    entry: impl Fn(u32, u32) -> Option<u32>,
) {
    let held = numbers.iter().flatten().count() as u32;
    for element in elements.iter_mut() {
        let own = triangles[element.triangle as usize].map(|v| numbers[v as usize]);
        element.rows = own.map(|number| number.map_or(held, &row));
        element.entries = PAIRS.map(|(a, b)| own[a].zip(own[b]).and_then(|(i, j)| entry(i, j)).unwrap_or(NONE));
    }
    elements.sort_by_key(|element| element.rows.into_iter().min());
}
