use mimesh_core::{
    Figures,
    mesh::Surface,
    operators::cotangent_laplacian,
    stage::{Deformer, Fit, HandleWeights, Regions, Skin},
    testkit::{contracts, meshes, random::Random},
};
use nalgebra::{DMatrix, Matrix3, Matrix3x4, Point3, Vector3};

use crate::{ArapSkinning, Difference, EdgeWeights, GlobalStep, LinearBlend};

/// Handles at some vertices of a surface, with weights that fall off with distance, and regions by nearest handle.
struct Case {
    surface: Surface,
    weights: HandleWeights,
    regions: Regions,
}

impl Case {
    fn new(surface: Surface, handles: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let mut at: Vec<Point3<f64>> = Vec::new();
        while at.len() < handles {
            let next = surface.positions[random.index(surface.vertex_count())];
            if at.iter().all(|other| (other - next).norm() > 0.15 * surface.diagonal()) {
                at.push(next);
            }
        }
        let near = 0.05 * surface.diagonal().powi(2);
        let mut matrix = DMatrix::from_fn(surface.vertex_count(), handles, |i, k| {
            (-(surface.positions[i] - at[k]).norm_squared() / near).exp() + 1e-9
        });
        matrix.row_iter_mut().for_each(|mut row| row /= row.sum());
        let of_vertex = matrix.row_iter().map(|row| row.transpose().argmax().0 as u32).collect();
        let regions = Regions { of_vertex, count: handles, figures: Figures::default() };
        Self { surface, weights: HandleWeights { matrix, figures: Figures::default() }, regions }
    }

    fn skin(&self, stage: &dyn Deformer) -> Box<dyn Skin> {
        stage.bind(&self.surface).unwrap().skin(&self.weights, &self.regions).unwrap()
    }

    fn fit(&self, stage: &dyn Deformer, posed: &[Point3<f64>]) -> Fit {
        self.skin(stage).fit(posed).unwrap()
    }

    /// The maps of handles as M (#V × 4h) multiplies them, 4h × 3.
    fn stacked(&self, maps: &[Matrix3x4<f64>]) -> DMatrix<f64> {
        DMatrix::from_fn(4 * maps.len(), 3, |i, c| maps[i / 4][(c, i % 4)])
    }

    /// M.
    fn basis(&self) -> DMatrix<f64> {
        let w = &self.weights.matrix;
        DMatrix::from_fn(w.nrows(), 4 * w.ncols(), |i, k| {
            w[(i, k / 4)] * if k % 4 < 3 { self.surface.positions[i][k % 4] } else { 1.0 }
        })
    }

    /// Both directions of each edge with its weight.
    fn spokes(&self) -> Vec<(usize, usize, f64)> {
        let lower = cotangent_laplacian(&self.surface.positions, &self.surface.triangles);
        let edges = lower.triplet_iter().filter(|(i, j, _)| i != j);
        edges.flat_map(|(i, j, value)| [(i, j, (-value).max(0.0)), (j, i, (-value).max(0.0))]).collect()
    }

    /// Eq. 3 as it is written, for one rotation a region.
    fn rigidity(&self, q: &[Point3<f64>], rotations: &[Matrix3<f64>]) -> f64 {
        let p = &self.surface.positions;
        let term = |(i, j, w): (usize, usize, f64)| {
            let r = rotations[self.regions.of_vertex[i] as usize];
            w * (q[i] - q[j] - r * (p[i] - p[j])).norm_squared()
        };
        self.spokes().into_iter().map(term).sum()
    }

    /// The rotations of eq. 21 by the singular vectors of Ŝ, where that is a reflection, with the least of them flipped.
    fn rotations(&self, q: &[Point3<f64>]) -> Vec<Matrix3<f64>> {
        let p = &self.surface.positions;
        let mut sums = vec![Matrix3::zeros(); self.regions.count];
        for (i, j, w) in self.spokes() {
            sums[self.regions.of_vertex[i] as usize] += (p[i] - p[j]) * (q[i] - q[j]).transpose() * w;
        }
        sums.into_iter()
            .map(|sum| {
                let svd = sum.svd(true, true);
                let (u, mut v) = (svd.u.unwrap(), svd.v_t.unwrap().transpose());
                if (v * u.transpose()).determinant() < 0.0 {
                    let flipped = -v.column(2);
                    v.set_column(2, &flipped);
                }
                v * u.transpose()
            })
            .collect()
    }

    /// Eq. 5 with the best rotations.
    fn energy(&self, q: &[Point3<f64>], posed: &[Point3<f64>], lambda: f64) -> f64 {
        let difference: f64 = q.iter().zip(posed).map(|(q, posed)| (q - posed).norm_squared()).sum();
        lambda * self.rigidity(q, &self.rotations(q)) + difference
    }
}

fn bar() -> Surface {
    let mut surface = meshes::bar([9, 3, 2], [3.0, 0.9, 0.7]);
    surface.positions.iter_mut().for_each(|p| *p = Point3::new(p.x, p.y + 0.1 * p.x * p.x, p.z * (1.0 + 0.2 * p.x)));
    surface
}

/// Twisted, bent, blown up and shaken.
fn deformed(surface: &Surface, seed: u64) -> Vec<Point3<f64>> {
    let mut random = Random::new(seed);
    let (axis, rate, growth) = (random.vector(), random.between(0.0, 1.5), random.between(-0.3, 0.3));
    let motion = random.rigid_motion(2.0);
    let moved = |p: &Point3<f64>| {
        let turned = nalgebra::Rotation3::new(axis * rate * p.x) * p.coords * (1.0 + growth * p.y);
        motion * Point3::from(turned + random.vector() * 0.02)
    };
    surface.positions.iter().map(moved).collect()
}

fn energies(fit: &Fit) -> Vec<f64> {
    fit.figures.values["energies"].as_array().unwrap().iter().map(|e| e.as_f64().unwrap()).collect()
}

/// Regularisation that leaves the energy to eq. 5 alone, as far as rounding allows.
fn to_the_letter() -> ArapSkinning {
    ArapSkinning { regularisation: 1e-12, tolerance: 1e-14, max_iterations: 2000, ..ArapSkinning::default() }
}

#[test]
fn all_keep_the_contract_of_deformers() {
    contracts::deformer("linear_blend", &LinearBlend::default());
    contracts::deformer("arap_skinning", &ArapSkinning::default());
    for difference in [Difference::Area, Difference::None] {
        contracts::deformer("arap_skinning", &ArapSkinning { difference, ..ArapSkinning::default() });
    }
    let stage = ArapSkinning { edge_weights: EdgeWeights::Uniform, ..ArapSkinning::default() };
    contracts::deformer("arap_skinning", &stage);
    contracts::deformer("arap_skinning", &ArapSkinning { global_step: GlobalStep::Stacked, ..ArapSkinning::default() });
    contracts::deformer("arap_skinning", &ArapSkinning { lambda: 0.0, ..ArapSkinning::default() });
}

#[test]
fn the_energy_never_rises() {
    for seed in 0..60 {
        let surface = if seed % 2 == 0 { bar() } else { meshes::capsule(10, 6, 3.0) };
        let case = Case::new(surface, 2 + seed as usize % 6, seed);
        let mut random = Random::new(seed);
        let stage = ArapSkinning {
            lambda: 10f64.powf(random.between(-3.0, 3.0)),
            difference: [Difference::Uniform, Difference::Area, Difference::None][seed as usize % 3],
            edge_weights: [EdgeWeights::Cotangent, EdgeWeights::SignedCotangent, EdgeWeights::Uniform]
                [seed as usize / 3 % 3],
            tolerance: 1e-12,
            ..ArapSkinning::default()
        };
        let found = energies(&case.fit(&stage, &deformed(&case.surface, seed)));
        for pair in found.windows(2) {
            // Energies are differences of sums that are larger, a thousand times where vertices are held.
            assert!(pair[1] <= pair[0] + 1e-11 * found[0].abs(), "seed {seed}: {pair:?} of {found:?}");
        }
    }
}

#[test]
fn the_energy_reported_is_equation_5() {
    for seed in 0..10 {
        let case = Case::new(bar(), 4, seed);
        let pose = deformed(&case.surface, seed);
        let found = case.fit(&to_the_letter(), &pose);
        let direct = case.energy(&found.positions, &pose, 0.5);
        let reported = found.figures.number("energy").unwrap();
        // At convergence, new rotations lower it by no more than the tolerance, and regularisation raises it by about 1e-12.
        assert!((direct - reported).abs() < 1e-9 * direct.abs(), "seed {seed}: {direct} and {reported}");
    }
}

#[test]
fn no_small_change_of_a_map_lowers_the_energy() {
    for seed in 0..5 {
        let case = Case::new(bar(), 3, seed);
        let pose = deformed(&case.surface, seed);
        let found = case.fit(&to_the_letter(), &pose);
        let (basis, maps) = (case.basis(), case.stacked(&found.transforms));
        let energy = |maps: &DMatrix<f64>| {
            let q: Vec<_> = (&basis * maps).row_iter().map(|row| Point3::new(row[0], row[1], row[2])).collect();
            case.energy(&q, &pose, 0.5)
        };
        let step = 1e-4;
        for i in 0..maps.len() {
            let moved = |by: f64| {
                let mut maps = maps.clone();
                maps.as_mut_slice()[i] += by;
                energy(&maps)
            };
            let (slope, curvature) = (
                (moved(step) - moved(-step)) / (2.0 * step),
                (moved(step) + moved(-step) - 2.0 * energy(&maps)) / step.powi(2),
            );
            // The minimum of the parabola through the three is where the maps are, to a part of the step.
            assert!(slope.abs() < 1e-5 * curvature, "seed {seed}, entry {i}: slope {slope:e}, curvature {curvature:e}");
        }
    }
}

/// T of the first global step of eq. 5 for rotations R: (2 λ Mᵀ L M + Mᵀ M) T = Mᵀ (λ C + q′), dense, from the definition.
fn dense_global_step(case: &Case, rotations: &[Matrix3<f64>], posed: &[Point3<f64>], lambda: f64) -> DMatrix<f64> {
    let p = &case.surface.positions;
    let n = p.len();
    let mut system = DMatrix::<f64>::identity(n, n);
    let mut rhs = DMatrix::from_fn(n, 3, |i, c| posed[i][c]);
    for (i, j, w) in case.spokes() {
        let goal = rotations[case.regions.of_vertex[i] as usize] * (p[i] - p[j]) * (lambda * w);
        for (a, sign) in [(i, 1.0), (j, -1.0)] {
            system[(a, i)] += lambda * w * sign;
            system[(a, j)] -= lambda * w * sign;
            (0..3).for_each(|c| rhs[(a, c)] += sign * goal[c]);
        }
    }
    let m = case.basis();
    (m.transpose() * system * &m).cholesky().unwrap().solve(&(m.transpose() * rhs))
}

#[test]
fn alternating_dense_steps_from_the_definition_end_at_the_same_maps() {
    let case = Case::new(meshes::bar([4, 2, 2], [2.0, 0.8, 0.7]), 2, 3);
    let pose = deformed(&case.surface, 1);
    let found = case.stacked(&case.fit(&to_the_letter(), &pose).transforms);
    let mut q = pose.clone();
    let mut maps = DMatrix::zeros(8, 3);
    for _ in 0..500 {
        maps = dense_global_step(&case, &case.rotations(&q), &pose, 0.5);
        q = (case.basis() * &maps).row_iter().map(|row| Point3::new(row[0], row[1], row[2])).collect();
    }
    // Both stop where energies differ by 1e-14, so maps by its root.
    assert!((&maps - &found).amax() < 1e-6, "{maps}{found}");
}

#[test]
fn a_vertex_that_stands_for_several_counts_as_often() {
    let case = Case::new(bar(), 4, 2);
    let pose = deformed(&case.surface, 1);
    let fit = |stage: &dyn Deformer, counts: &[f64]| {
        let skin = stage.bind_coarse(&case.surface, counts).unwrap().skin(&case.weights, &case.regions).unwrap();
        skin.fit(&pose).unwrap().positions
    };
    let farthest =
        |a: &[Point3<f64>], b: &[Point3<f64>]| a.iter().zip(b).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    let count = case.surface.vertex_count();
    let (one, three) = (vec![1.0; count], vec![3.0; count]);
    let stiffer = ArapSkinning { lambda: 3.0 * 0.5, ..ArapSkinning::default() };
    let plain = fit(&ArapSkinning::default(), &one);
    assert_eq!(plain, case.fit(&ArapSkinning::default(), &pose).positions);
    // The whole energy is three times as large: rounding remains.
    assert!(farthest(&plain, &fit(&stiffer, &three)) < 1e-9);
    assert!(farthest(&plain, &fit(&ArapSkinning::default(), &three)) > 1e-6, "closeness counts more");
    let blend = LinearBlend::default();
    assert!(farthest(&fit(&blend, &one), &fit(&blend, &three)) < 1e-9, "all alike");
    // The half that counts is met better.
    let half: Vec<f64> = case.surface.positions.iter().map(|p| if p.x > 0.0 { 100.0 } else { 1.0 }).collect();
    let off = |fit: &[Point3<f64>]| -> f64 {
        let counted = fit.iter().zip(&pose).zip(&half).filter(|(_, c)| **c > 1.0);
        counted.map(|((p, q), _)| (p - q).norm_squared()).sum()
    };
    assert!(off(&fit(&blend, &half)) < off(&fit(&blend, &one)));
    assert!(blend.bind_coarse(&case.surface, &one[1..]).is_err());
}

#[test]
fn an_affine_pose_is_met_where_closeness_counts_most() {
    let case = Case::new(bar(), 4, 2);
    let affine =
        |p: &Point3<f64>| Point3::new(1.5 * p.x + 0.3 * p.y + 4.0, 0.7 * p.y - 0.2 * p.z, p.z + 0.4 * p.x - 1.0);
    let pose: Vec<_> = case.surface.positions.iter().map(affine).collect();
    let close = ArapSkinning { lambda: 1e-9, regularisation: 1e-12, ..ArapSkinning::default() };
    let exact = LinearBlend { regularisation: 1e-12 };
    for (stage, tolerance) in
        [(&close as &dyn Deformer, 1e-6), (&exact, 1e-9), (&LinearBlend { regularisation: 1e-6 }, 1e-4)]
    {
        let found = case.fit(stage, &pose);
        let worst = found.positions.iter().zip(&pose).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
        // The rigidity and the regularisation pull by about their share.
        assert!(worst < tolerance, "{stage:?}: {worst:e}");
    }
}

#[test]
fn a_rigid_motion_is_met_however_small_regions_and_obtuse_triangles_are() {
    let mut surface = meshes::icosphere(2);
    surface.positions.iter_mut().for_each(|p| p.x *= 6.0);
    let mut case = Case::new(surface, 3, 1);
    let count = case.surface.vertex_count();
    case.regions = Regions { of_vertex: (0..count as u32).collect(), count, figures: Figures::default() };
    let motion = Random::new(4).rigid_motion(3.0);
    let pose: Vec<_> = case.surface.positions.iter().map(|p| motion * p).collect();
    let found = case.fit(&ArapSkinning { lambda: 10.0, ..ArapSkinning::default() }, &pose);
    for (p, q) in found.positions.iter().zip(&pose) {
        assert!((p - q).norm() < 1e-12, "rounding at lengths of about 10");
    }
}

#[test]
fn scale_place_and_facing_of_meshes_change_nothing_but_scale_place_and_facing() {
    let case = Case::new(bar(), 4, 5);
    let pose = deformed(&case.surface, 5);
    let found = case.fit(&ArapSkinning::default(), &pose);
    let motion = Random::new(8).rigid_motion(30.0);
    for scale in [1e-3, 1.0, 1e4] {
        let rest = |p: &Point3<f64>| Point3::from(p.coords * scale) + Vector3::new(5.0, -7.0, 2.0) * scale;
        let posed = |p: &Point3<f64>| motion * Point3::from(p.coords * scale);
        let mut surface = case.surface.clone();
        surface.positions = surface.positions.iter().map(rest).collect();
        let other = Case { surface, weights: case.weights.clone(), regions: case.regions.clone() };
        let pose: Vec<_> = pose.iter().map(posed).collect();
        let moved = other.fit(&ArapSkinning::default(), &pose);
        for (p, q) in moved.positions.iter().zip(&found.positions) {
            // Rounding at coordinates some ten times as large as the mesh, or thirty units.
            assert!((p - posed(q)).norm() < 1e-9 * scale.max(1.0), "{scale}");
        }
    }
}

#[test]
fn a_flat_sheet_bends_with_maps_that_stay_near_rotations() {
    let sheet = meshes::grid(12, 4);
    let case = Case::new(sheet, 4, 1);
    let bend = |p: &Point3<f64>| Point3::new(p.x.sin(), p.y, 1.0 - p.x.cos());
    let pose: Vec<_> = case.surface.positions.iter().map(bend).collect();
    for stage in [&ArapSkinning::default() as &dyn Deformer, &LinearBlend::default()] {
        for map in case.fit(stage, &pose).transforms {
            // Nothing is known across the sheet; the rigid motion fills it in.
            let across = map.column(2);
            assert!((across.norm() - 1.0).abs() < 0.2 && across.z > 0.0, "{stage:?}: {map}");
        }
    }
}

#[test]
fn a_pose_turned_inside_out_or_collapsed_gives_finite_maps() {
    let case = Case::new(bar(), 3, 7);
    for scale in
        [Vector3::new(-1.0, 1.0, 1.0), Vector3::new(1.0, 0.0, 1.0), Vector3::new(1.0, 0.0, 0.0), Vector3::zeros()]
    {
        let pose: Vec<_> =
            case.surface.positions.iter().map(|p| Point3::from(p.coords.component_mul(&scale))).collect();
        for stage in [&ArapSkinning::default() as &dyn Deformer, &LinearBlend::default()] {
            let found = case.fit(stage, &pose);
            assert!(found.transforms.iter().all(|map| map.iter().all(|x| x.is_finite())), "{stage:?}: {scale}");
        }
    }
}

#[test]
fn the_step_of_the_paper_solves_the_stacked_system() {
    let case = Case::new(meshes::bar([4, 2, 2], [2.0, 0.8, 0.7]), 2, 3);
    let pose = deformed(&case.surface, 1);
    let stage =
        ArapSkinning { global_step: GlobalStep::Stacked, max_iterations: 500, tolerance: 0.0, ..to_the_letter() };
    let found = case.fit(&stage, &pose);
    let maps = case.stacked(&found.transforms);
    // [λL; I] M T = [λb; q′] by least squares, with the rotations of the positions found.
    let (p, rotations) = (&case.surface.positions, case.rotations(&found.positions));
    let n = p.len();
    let (mut l, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, 3));
    for (i, j, w) in case.spokes() {
        l[(i, i)] += w;
        l[(i, j)] -= w;
        let mean =
            0.5 * (rotations[case.regions.of_vertex[i] as usize] + rotations[case.regions.of_vertex[j] as usize]);
        let goal = mean * (p[i] - p[j]) * w;
        (0..3).for_each(|c| b[(i, c)] += goal[c]);
    }
    let m = case.basis();
    let residual = |maps: &DMatrix<f64>| {
        let q = &m * maps;
        let wanted = DMatrix::from_fn(n, 3, |i, c| pose[i][c]);
        let (upper, lower) = ((&l * &q - &b) * 0.5, q - wanted);
        m.transpose() * (l.transpose() * upper * 0.5 + lower)
    };
    let size = (m.transpose() * DMatrix::from_fn(n, 3, |i, c| pose[i][c])).amax();
    assert!(residual(&maps).amax() < 1e-8 * size, "normal equations: {}", residual(&maps));
}

#[test]
fn weights_that_do_not_sum_to_one_are_named() {
    let mut case = Case::new(bar(), 3, 7);
    case.weights.matrix[(4, 1)] += 0.5;
    let bound = ArapSkinning::default().bind(&case.surface).unwrap();
    let error = bound.skin(&case.weights, &case.regions).unwrap_err();
    assert_eq!(error.to_string(), "the weights of vertex 4 (from 0) sum to 1.5: expected 1");
    assert!(error.hint().is_some());
}

#[test]
fn settings_out_of_range_are_named() {
    let error = ArapSkinning { lambda: -1.0, ..ArapSkinning::default() }.bind(&bar()).unwrap_err();
    assert_eq!(error.to_string(), "lambda: expected 0 to 1000000, found -1");
}
