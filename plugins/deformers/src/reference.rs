//! Rigid motions nearest to a pose: of the whole surface, of each handle, of each region.

use mimesh_core::{
    mesh::diagonal,
    operators::{polar, rotations},
    stage::Regions,
};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};

use crate::handle_space::HandleSpace;

/// How much of the motion of the whole is mixed into that of a part, so that a part which is a point or a line has one.
const WHOLE_SHARE: f64 = 1e-3;

/// The rest positions, prepared for rigid fits of the whole and of regions.
#[derive(Clone, Debug)]
pub(crate) struct RestShape {
    /// V, #V.
    pub positions: Vec<Point3<f64>>,
    /// The diagonal of the bounding box.
    pub diagonal: f64,
    centre: Point3<f64>,
    /// p − centre.
    centred: Vec<Vector3<f64>>,
    /// Σ over all vertices of (p − centre)(p − centre)ᵀ.
    spread: Matrix3<f64>,
}

/// A pose seen from the rigid motion of the whole.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    rotation: Matrix3<f64>,
    rest_centre: Point3<f64>,
    posed_centre: Point3<f64>,
    /// δ: from the rest position of each vertex to the pose moved back, #V.
    pub displacements: Vec<Vector3<f64>>,
}

impl RestShape {
    pub(crate) fn new(rest: &[Point3<f64>]) -> Self {
        let centre = mean(rest);
        let centred: Vec<_> = rest.iter().map(|p| p - centre).collect();
        let spread = centred.iter().map(|p| p * p.transpose()).sum();
        Self { positions: rest.to_vec(), diagonal: diagonal(rest), centre, centred, spread }
    }

    /// Takes the rigid motion of the whole off `posed` (#V).
    pub(crate) fn see(&self, posed: &[Point3<f64>]) -> Seen {
        let posed_centre = mean(posed);
        let mut covariance = Matrix3::zeros();
        for (p, q) in self.centred.iter().zip(posed) {
            covariance += (q - posed_centre) * p.transpose();
        }
        let rotation = polar(&covariance).rotation;
        let back = rotation.transpose();
        let displacements = self.centred.iter().zip(posed).map(|(p, q)| back * (q - posed_centre) - p).collect();
        Seen { rotation, rest_centre: self.centre, posed_centre, displacements }
    }

    /// For each region the rotation of its own best rigid motion.
    pub(crate) fn rotations(&self, displacements: &[Vector3<f64>], regions: &Regions) -> Vec<Matrix3<f64>> {
        let mut sums = vec![(0.0, Vector3::zeros(), Vector3::zeros(), Matrix3::zeros()); regions.count];
        for ((p, d), &g) in self.centred.iter().zip(displacements).zip(&regions.of_vertex) {
            let (count, rest, moved, covariance) = &mut sums[g as usize];
            let q = p + d;
            *count += 1.0;
            *rest += p;
            *moved += q;
            *covariance += q * p.transpose();
        }
        let whole = self.spread * (WHOLE_SHARE / self.centred.len() as f64);
        let covariances = sums.into_iter().map(|(count, rest, moved, covariance)| {
            let own = covariance - moved * rest.transpose() / f64::max(count, 1.0);
            own + whole * (WHOLE_SHARE * count)
        });
        rotations(&covariances.collect::<Vec<_>>())
    }
}

impl Seen {
    /// The place to which the rigid motion of the whole takes `p`.
    pub(crate) fn forth(&self, p: &Point3<f64>) -> Point3<f64> {
        self.posed_centre + self.rotation * (p - self.rest_centre)
    }

    /// A map in the rest frame, followed by the rigid motion of the whole.
    pub(crate) fn after(&self, (linear, shift): (Matrix3<f64>, Vector3<f64>)) -> (Matrix3<f64>, Vector3<f64>) {
        let still = self.posed_centre.coords - self.rotation * self.rest_centre.coords;
        (self.rotation * linear, self.rotation * shift + still)
    }
}

/// For each handle what it moves, in its own frame x = (p − c) / s, and how much that counts.
#[derive(Clone, Debug)]
pub(crate) struct HandleShapes {
    shapes: Vec<Shape>,
}

#[derive(Clone, Debug)]
struct Shape {
    /// Σ d w.
    mass: f64,
    /// Σ d w x.
    first: Vector3<f64>,
    /// Σ d w x xᵀ, about the mean.
    spread: Matrix3<f64>,
    /// Added to sums that are divided by, in place of a mass that may be 0.
    floor: f64,
    /// What `spread` lacks to be positive semi-definite, as with weights below 0. Without it the rest would have a turn.
    lack: f64,
}

impl HandleShapes {
    /// Made of sums like Mᵀ D M: `factors` is the diagonal of D.
    pub(crate) fn new(space: &HandleSpace, factors: &[f64], weights: &DMatrix<f64>, rest: &[Point3<f64>]) -> Self {
        let total: f64 = factors.iter().sum();
        let floor = WHOLE_SHARE * WHOLE_SHARE * total / weights.ncols() as f64;
        let shapes = weights.column_iter().enumerate().map(|(k, column)| {
            let (mut mass, mut first, mut spread) = (0.0, Vector3::zeros(), Matrix3::zeros());
            for ((p, &w), d) in rest.iter().zip(column.iter()).zip(factors) {
                let weight = d * w;
                if weight != 0.0 {
                    let x = (p - space.centres[k]) / space.radii[k];
                    mass += weight;
                    first += x * weight;
                    spread += x * x.transpose() * weight;
                }
            }
            let floor = floor.max(f64::MIN_POSITIVE.sqrt());
            let spread = spread - first * first.transpose() / (mass.abs() + floor);
            let lack = (-spread.symmetric_eigenvalues().min()).max(0.0);
            Shape { mass, first, spread, floor, lack }
        });
        Self { shapes: shapes.collect() }
    }

    /// X of the best rigid motion of each handle, 4h × 3, for `projected` = Mᵀ D δ.
    pub(crate) fn rigid(&self, space: &HandleSpace, projected: &DMatrix<f64>) -> DMatrix<f64> {
        // What moves nothing, or with unbounded weights more against than along: the motion of the whole will do.
        let moving: Vec<usize> = (0..self.shapes.len()).filter(|&k| self.shapes[k].mass > 0.0).collect();
        let moved = |k: usize| projected.fixed_view::<1, 3>(4 * k + 3, 0).into_owned();
        let covariance = |&k: &usize| {
            let (shape, radius) = (&self.shapes[k], space.radii[k]);
            let turned = projected.fixed_view::<3, 3>(4 * k, 0).into_owned();
            // Σ d w (x − x̄)(q − q̄)ᵀ with q = s x + δ.
            let covariance = shape.spread * radius + turned - shape.first * moved(k) / (shape.mass + shape.floor);
            let still = (WHOLE_SHARE * shape.spread.trace().abs() + shape.floor + shape.lack) * radius;
            covariance.transpose() + Matrix3::identity() * still
        };
        let rotations = rotations(&moving.iter().map(covariance).collect::<Vec<_>>());
        let mut result = DMatrix::zeros(space.size(), 3);
        for (&k, rotation) in moving.iter().zip(&rotations) {
            let (shape, mass) = (&self.shapes[k], self.shapes[k].mass + self.shapes[k].floor);
            let turn = (rotation - Matrix3::identity()) * space.radii[k];
            let mean = shape.first / mass;
            result.fixed_view_mut::<3, 3>(4 * k, 0).copy_from(&turn.transpose());
            result.fixed_view_mut::<1, 3>(4 * k + 3, 0).copy_from(&(moved(k) / mass - (turn * mean).transpose()));
        }
        result
    }
}

fn mean(points: &[Point3<f64>]) -> Point3<f64> {
    Point3::from(points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len().max(1) as f64)
}
