//! Positions whose deformation gradients come closest to a given field.

use mimesh_core::{
    Result,
    linalg::{Assembly, Cholesky},
    mesh::Surface,
    operators::{Gradient, gradients},
};
use nalgebra::{Matrix3, Point3};

/// How strongly the edges of triangles without area are held, in units of cotangent weight: enough to tie a vertex that has
/// no other triangle, too little to be felt by one that has.
const DEGENERATE_WEIGHT: f64 = 1e-4;

/// Reweighting stops once a step lowers the energy by less than this part of it.
const MIN_ENERGY_DECREASE: f64 = 1e-3;

/// Minimises Σ_t w_t ρ(‖(F̂_t − F_t) P_t‖) over the posed vertices of a surface, for any number of fields F̂.
///
/// In the 3 × 2 edge form (Botsch et al. 2006): P_t projects onto the plane of triangle t, and the fourth vertex of Sumner
/// and Popović 2004 drops out. ρ(r) = r² is their least squares, for which the matrix (with w_t the area, the cotangent
/// Laplacian) is factored once. ρ(r) = 2ε (√(r² + ε²) − ε), nearly |r|, is minimised by reweighting: each step minimises a
/// quadratic that lies above the energy and touches it, so the energy never rises; the energy is convex, so there is one
/// minimum.
#[derive(Debug)]
pub struct Poisson {
    factored: Cholesky,
    /// The values of the lower triangle for the regularization alone.
    regularization: Vec<f64>,
    elements: Vec<Element>,
    rest: Vec<Point3<f64>>,
    /// For each vertex its unknown; `None` for anchors and for vertices without a triangle.
    unknown: Vec<Option<u32>>,
    /// For each vertex the anchor of its component; itself without a triangle.
    anchor: Vec<u32>,
}

/// A triangle of the surface.
#[derive(Debug)]
struct Element {
    corners: [u32; 3],
    /// `None` if it has no area.
    gradient: Option<Gradient>,
    /// w_t; 0 if it has no area.
    weight: f64,
    /// The factor of a field in the right-hand side of each corner, times the weight: gᵢ as columns.
    rhs: Matrix3<f64>,
    /// Where the pairs of corners [`PAIRS`] lie among the values of the matrix.
    entries: [Option<u32>; 6],
}

const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// A solution and what it took.
#[derive(Debug)]
pub struct Solution {
    /// The posed vertices, #V.
    pub positions: Vec<Point3<f64>>,
    /// √(Σ w_t ‖(F̂_t − F_t) P_t‖² / Σ w_t): how far the gradients are from the field, without unit.
    pub residual: f64,
    /// The energy that was minimised, over Σ w_t, after each solve.
    pub energies: Vec<f64>,
}

impl Poisson {
    /// Factors the system of `target`; `weight` gives w_t from a triangle's area.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](mimesh_core::Error::Singular) if positions do not say where a vertex is, as those that are not finite.
    pub fn new(target: &Surface, weight: impl Fn(f64) -> f64) -> Result<Self> {
        let (unknown, anchor) = unknowns(target);
        let mut elements: Vec<_> =
            target.triangles.iter().map(|&corners| Element::new(target, corners, &weight)).collect();
        // Relative to cotangents, so that the regularization has the same effect whatever the weights.
        let area: f64 = elements.iter().filter_map(|e| Some(e.gradient?.area)).sum();
        let scale = area / elements.iter().map(|e| e.weight).sum::<f64>();
        elements.iter_mut().for_each(|e| e.weight *= scale);

        let mut pattern = Assembly::new(unknown.iter().flatten().count());
        for element in &mut elements {
            let value = if element.gradient.is_none() { element.regularize(&target.positions) } else { 0.0 };
            for (a, b) in PAIRS {
                if let (Some(i), Some(j)) = (unknown[element.corners[a] as usize], unknown[element.corners[b] as usize])
                {
                    // Two corners at one vertex: the pair stands for both entries off the diagonal.
                    let share = if a == b {
                        2.0 * value
                    } else if i == j {
                        -2.0 * value
                    } else {
                        -value
                    };
                    pattern.add(i as usize, j as usize, share);
                }
            }
        }
        let matrix = pattern.finish();
        let (starts, rows, regularization) = matrix.csc_data();
        for element in &mut elements {
            element.entries = PAIRS.map(|(a, b)| {
                let (i, j) = (unknown[element.corners[a] as usize]?, unknown[element.corners[b] as usize]?);
                let (column, row) = (i.min(j) as usize, i.max(j) as usize);
                let place = rows[starts[column]..starts[column + 1]].binary_search(&row).ok()?;
                Some((starts[column] + place) as u32)
            });
        }
        let regularization = regularization.to_vec();
        let mut values = regularization.clone();
        add_stiffness(&elements, |_| 1.0, &mut values);
        let mut matrix = matrix;
        matrix.values_mut().copy_from_slice(&values);
        let factored = Cholesky::new(matrix, "the system of the target's deformation gradients")?;
        Ok(Self { factored, regularization, elements, rest: target.positions.clone(), unknown, anchor })
    }

    /// The posed vertices for the field `field` (#F): least squares, then at most `steps` reweightings with ε = `epsilon`.
    ///
    /// The first corner of the first triangle of each component stays where it is at rest; of vertices without a triangle this
    /// says nothing.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](mimesh_core::Error::Singular) if weights have become too uneven to be solved.
    pub fn solve(&self, field: &[Matrix3<f64>], steps: usize, epsilon: f64) -> Result<Solution> {
        let total: f64 = self.elements.iter().map(|e| e.weight).sum();
        let energy = |residuals: &[f64]| {
            let rho = |r: f64| {
                if steps == 0 { r * r } else { 2.0 * epsilon * ((r * r + epsilon * epsilon).sqrt() - epsilon) }
            };
            self.elements.iter().zip(residuals).map(|(e, &r)| e.weight * rho(r)).sum::<f64>() / total
        };
        let mut positions = self.solve_weighted(&self.factored, field, |_| 1.0);
        let mut residuals = self.residuals(field, &positions);
        let mut energies = vec![energy(&residuals)];
        for _ in 0..steps {
            let weight = |t: usize| epsilon / (residuals[t] * residuals[t] + epsilon * epsilon).sqrt();
            let mut values = self.regularization.clone();
            add_stiffness(&self.elements, weight, &mut values);
            let factored = self.factored.with_values(&values)?;
            positions = self.solve_weighted(&factored, field, weight);
            residuals = self.residuals(field, &positions);
            let (before, now) = (energies[energies.len() - 1], energy(&residuals));
            energies.push(now);
            if before - now <= MIN_ENERGY_DECREASE * before {
                break;
            }
        }
        let squares = self.elements.iter().zip(&residuals).map(|(e, r)| e.weight * r * r);
        Ok(Solution { residual: (squares.sum::<f64>() / total).sqrt(), positions, energies })
    }

    fn solve_weighted(
        &self,
        system: &Cholesky,
        field: &[Matrix3<f64>],
        weight: impl Fn(usize) -> f64,
    ) -> Vec<Point3<f64>> {
        let n = system.size();
        let mut x = vec![0.0; 3 * n];
        for (t, (element, f)) in self.elements.iter().zip(field).enumerate() {
            let b = f * element.rhs * if element.gradient.is_some() { element.weight * weight(t) } else { 1.0 };
            for (k, &v) in element.corners.iter().enumerate() {
                if let Some(i) = self.unknown[v as usize] {
                    (0..3).for_each(|c| x[c * n + i as usize] += b[(c, k)]);
                }
            }
        }
        // Relative to the anchor, which drops out by that.
        system.solve_in_place(&mut x, 3);
        let anchor = |v: usize| self.rest[self.anchor[v] as usize];
        let place = |v: usize| match self.unknown[v] {
            Some(i) => anchor(v) + nalgebra::Vector3::new(x[i as usize], x[n + i as usize], x[2 * n + i as usize]),
            None => self.rest[v],
        };
        (0..self.rest.len()).map(place).collect()
    }

    /// ‖(F̂_t − F_t) P_t‖ of each triangle; 0 without area.
    fn residuals(&self, field: &[Matrix3<f64>], posed: &[Point3<f64>]) -> Vec<f64> {
        let residual = |(element, f): (&Element, &Matrix3<f64>)| {
            let Some(gradient) = &element.gradient else { return 0.0 };
            // At rest the gradient of positions is the projection P itself.
            let projection = gradient.of_posed(&element.corners.map(|v| self.rest[v as usize]));
            (f * projection - gradient.of_posed(&element.corners.map(|v| posed[v as usize]))).norm()
        };
        self.elements.iter().zip(field).map(residual).collect()
    }
}

impl Element {
    fn new(target: &Surface, corners: [u32; 3], weight: impl Fn(f64) -> f64) -> Self {
        let gradient = gradients(&target.positions, &[corners])[0];
        let rhs = gradient.map_or_else(Matrix3::zeros, |g| g.of_corners);
        Self { corners, gradient, weight: gradient.map_or(0.0, |g| weight(g.area)), rhs, entries: [None; 6] }
    }

    /// Holds the edges of a triangle without area; returns their weight.
    fn regularize(&mut self, rest: &[Point3<f64>]) -> f64 {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let edge = (rest[self.corners[a] as usize] - rest[self.corners[b] as usize]) * DEGENERATE_WEIGHT;
            let (at_a, at_b) = (self.rhs.column(a) + edge, self.rhs.column(b) - edge);
            self.rhs.set_column(a, &at_a);
            self.rhs.set_column(b, &at_b);
        }
        DEGENERATE_WEIGHT
    }
}

/// Adds w_t weight(t) gᵢ · gⱼ of all triangles with an area to the values of the lower triangle.
fn add_stiffness(elements: &[Element], weight: impl Fn(usize) -> f64, values: &mut [f64]) {
    for (t, element) in elements.iter().enumerate() {
        let Some(gradient) = &element.gradient else { continue };
        let w = element.weight * weight(t);
        for ((a, b), entry) in PAIRS.into_iter().zip(element.entries) {
            if let Some(entry) = entry {
                values[entry as usize] += w * gradient.of_corners.column(a).dot(&gradient.of_corners.column(b));
            }
        }
    }
}

/// A number for each vertex that a triangle uses but for one a component, its anchor; and for each vertex its anchor.
fn unknowns(target: &Surface) -> (Vec<Option<u32>>, Vec<u32>) {
    let components = target.components();
    let mut anchor: Vec<u32> = (0..target.vertex_count() as u32).collect();
    let mut first = vec![None; components.count()];
    let mut used = vec![false; target.vertex_count()];
    for &v in target.triangles.iter().flatten() {
        if let Some(c) = components.of_vertex[v as usize] {
            anchor[v as usize] = *first[c as usize].get_or_insert(v);
            used[v as usize] = anchor[v as usize] != v;
        }
    }
    let mut count = 0;
    let number = |used: &bool| {
        used.then(|| {
            count += 1;
            count - 1
        })
    };
    (used.iter().map(number).collect(), anchor)
}
