//! Laws of the operators, on generated meshes of any shape and size.

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};
use nalgebra_sparse::CscMatrix;
use proptest::prelude::*;

use super::*;
use crate::{
    mesh::Surface,
    testkit::{meshes, random::Random},
};

/// A sphere or a bar with every vertex shaken by up to a fifth of an edge, and scaled: closed, irregular, no symmetry.
fn shaken(seed: u64, scale: f64) -> Surface {
    let mut random = Random::new(seed);
    let mut surface =
        if seed.is_multiple_of(2) { meshes::icosphere(2) } else { meshes::bar([6, 3, 2], [3.0, 1.0, 0.7]) };
    let t = surface.triangles[0];
    let edge = (surface.positions[t[0] as usize] - surface.positions[t[1] as usize]).norm();
    surface.positions.iter_mut().for_each(|p| *p = Point3::from((p.coords + random.vector() * (0.2 * edge)) * scale));
    surface
}

fn full(lower: &CscMatrix<f64>) -> DMatrix<f64> {
    let lower = DMatrix::from(lower);
    &lower + lower.transpose() - DMatrix::from_diagonal(&lower.diagonal())
}

/// A power of ten from 1e-6 to 1e6.
fn scales() -> impl Strategy<Value = f64> {
    (-6..=6i32).prop_map(|e| 10f64.powi(e))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_laplacian_is_positive_semi_definite_and_kills_constants(seed: u64, scale in scales()) {
        let s = shaken(seed, scale);
        let l = full(&cotangent_laplacian(&s.positions, &s.triangles));
        let ones = DVector::from_element(s.vertex_count(), 1.0);
        // Entries are of order 1 whatever the scale; a row sums a dozen of them.
        prop_assert!((&l * ones).amax() < 1e-12);
        prop_assert!(l.symmetric_eigenvalues().min() > -1e-10);
    }

    #[test]
    fn the_laplacian_is_the_divergence_of_the_gradient(seed: u64, scale in scales()) {
        let s = shaken(seed, scale);
        let n = s.vertex_count();
        let mut product = DMatrix::<f64>::zeros(n, n);
        for (t, g) in s.triangles.iter().zip(gradients(&s.positions, &s.triangles)) {
            let g = g.expect("shaken triangles have an area");
            let block = g.of_corners.transpose() * g.of_corners * g.area;
            for (i, &v) in t.iter().enumerate() {
                for (j, &w) in t.iter().enumerate() {
                    product[(v as usize, w as usize)] += block[(i, j)];
                }
            }
        }
        let l = full(&cotangent_laplacian(&s.positions, &s.triangles));
        // The same numbers by another way; both are of order 1 with a few roundings.
        prop_assert!((l - product).amax() < 1e-11);
    }

    #[test]
    fn masses_sum_to_the_area_and_are_positive(seed: u64, scale in scales()) {
        let s = shaken(seed, scale);
        let mass = voronoi_mass(&s.positions, &s.triangles);
        let area: f64 = s.area_normals(&s.positions).iter().map(|n| n.norm() / 2.0).sum();
        // Relative: a sum of some hundred terms.
        prop_assert!((mass.iter().sum::<f64>() / area - 1.0).abs() < 1e-12);
        prop_assert!(mass.iter().all(|m| *m > 0.0));
    }

    #[test]
    fn an_affine_map_is_its_own_deformation_gradient_in_every_plane(seed: u64, scale in scales()) {
        let s = shaken(seed, scale);
        let map = Matrix3::identity() + Random::new(seed).matrix() * 0.3;
        let posed: Vec<_> = s.positions.iter().map(|p| Point3::from(map * p.coords) + Vector3::new(5.0, 1.0, -2.0) * scale).collect();
        let of_rest = DeformationGradients::new(&s.positions, &s.triangles);
        for (t, g) in gradients(&s.positions, &s.triangles).into_iter().enumerate() {
            let g = g.expect("shaken triangles have an area");
            let plane = g.of_posed(&s.corners(&s.positions, t));
            let edge_form = g.of_posed(&s.corners(&posed, t));
            // Thin triangles lose a few digits in 1 / area.
            prop_assert!((edge_form - map * plane).norm() < 1e-9);
            prop_assert!((of_rest.of_triangle(t, &posed) * plane - map * plane).norm() < 1e-9);
        }
    }

    #[test]
    fn a_rigid_motion_has_its_rotation_as_deformation_gradient(seed: u64, scale in scales()) {
        let s = shaken(seed, scale);
        let motion = Random::new(seed).rigid_motion(10.0 * scale);
        let posed: Vec<_> = s.positions.iter().map(|p| motion * p).collect();
        let rotation = motion.rotation.to_rotation_matrix();
        for f in DeformationGradients::new(&s.positions, &s.triangles).of(&posed) {
            prop_assert!((f - rotation.matrix()).norm() < 1e-9);
        }
    }

    #[test]
    fn polar_gives_a_rotation_and_a_symmetric_rest(seed: u64, scale in scales(), flat: bool) {
        let mut f = Random::new(seed).matrix() * scale;
        if flat {
            // Rank 2: what a triangle pressed to an edge gives.
            f.set_column(2, &(f.column(0) * 0.5));
        }
        let Polar { rotation, stretch } = polar(&f);
        prop_assert!((rotation.transpose() * rotation - Matrix3::identity()).norm() < 1e-12);
        prop_assert!((rotation.determinant() - 1.0).abs() < 1e-12);
        // Relative to the matrix, whose condition is not bounded here; S is made symmetric at the cost of what is left.
        prop_assert!((rotation * stretch - f).norm() < 1e-7 * f.norm());
        if f.determinant() > 1e-3 * f.norm().powi(3) {
            prop_assert!(stretch.symmetric_eigenvalues().min() > 0.0);
        }
    }
}

#[test]
fn rotations_of_many_are_those_of_each() {
    let mut random = Random::new(5);
    let mut all: Vec<_> = (0..30).map(|_| random.matrix()).collect();
    all[3] = Matrix3::zeros();
    all[12] = -all[12];
    all[20] *= 1e-200;
    all[21].set_column(1, &Vector3::zeros());
    let together = rotations(&all);
    assert_eq!(together.len(), all.len());
    assert!(all.iter().zip(&together).all(|(f, r)| polar(f).rotation == *r));
}

#[test]
fn polar_of_a_reflection_is_the_nearest_rotation_and_not_the_negated_matrix() {
    let f = Matrix3::from_diagonal(&Vector3::new(3.0, 2.0, -1.0));
    // The axis of the smallest stretch is the cheapest to flip; Yang et al. 2018 after eq. 21 would negate all three.
    assert!((polar(&f).rotation - Matrix3::identity()).norm() < 1e-14);
}

#[test]
fn polar_keeps_its_digits_where_singular_values_are_small() {
    let (left, right) = (Random::new(1).rotation(), Random::new(2).rotation());
    let (u, v) = (left.to_rotation_matrix(), right.to_rotation_matrix());
    for s in [1e-3, 1e-5, 1e-7, 1e-9] {
        for sign in [1.0, -1.0] {
            let f = u.matrix() * Matrix3::from_diagonal(&Vector3::new(1.0, s, sign * s / 2.0)) * v.matrix().transpose();
            // The direction of a singular value s is known to ε / s.
            let error = (polar(&f).rotation - u.matrix() * v.matrix().transpose()).norm();
            assert!(error < 1e-14 / s, "{s}: {error}");
        }
    }
}

#[test]
fn linear_functions_on_a_plane_have_no_laplacian_inside() {
    let s = meshes::grid(6, 5);
    let l = full(&cotangent_laplacian(&s.positions, &s.triangles));
    let u = DVector::from_iterator(s.vertex_count(), s.positions.iter().map(|p| 3.0 * p.x - 2.0 * p.y + 1.0));
    let boundary: std::collections::HashSet<u32> = s.topology().boundary.into_iter().flatten().collect();
    let lu = l * u;
    for v in (0..s.vertex_count() as u32).filter(|v| !boundary.contains(v)) {
        // A dozen terms of order 10.
        assert!(lu[v as usize].abs() < 1e-12, "vertex {v}: {}", lu[v as usize]);
    }
}

#[test]
fn triangles_without_area_give_no_nan() {
    let s = Surface::new(&meshes::with_zero_area_triangle()).expect("a valid mesh");
    assert!(gradients(&s.positions, &s.triangles).iter().any(Option::is_none), "the fixture has a degenerate triangle");
    assert!(cotangent_laplacian(&s.positions, &s.triangles).values().iter().all(|x| x.is_finite()));
    assert!(voronoi_mass(&s.positions, &s.triangles).iter().all(|x| x.is_finite()));
    assert!(vertex_normals(&s.positions, &s.triangles).iter().all(|n| n.iter().all(|x| x.is_finite())));
    let of_rest = DeformationGradients::new(&s.positions, &s.triangles);
    let collapsed = vec![Point3::origin(); s.vertex_count()];
    assert!(of_rest.of(&collapsed).iter().all(|f| f.iter().all(|x| x.is_finite())));
}

#[test]
fn nan_counts_as_degenerate() {
    let p = Point3::new(f64::NAN, 0.0, 0.0);
    assert!(is_degenerate(&[p, Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)]));
}
