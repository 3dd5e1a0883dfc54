//! The contract of deformers.

use nalgebra::{DMatrix, Isometry3, Matrix3x4, Point3};

use super::{
    random::Random,
    support::{bent_bar, near, one_thread, twisted, with_defects},
};
use crate::{
    Figures,
    mesh::Surface,
    operators::linear_blend,
    stage::{Deformer, Fit, HandleWeights, Regions, Skin},
};

/// Entries of maps pass a factorisation whose condition is that of the regularisation.
const MAP_TOLERANCE: f64 = 1e-8;

/// The contract of [`Deformer`], on a sound surface and on one with defects, with good handles and with poor ones.
pub fn deformer(name: &str, stage: &dyn Deformer) {
    for surface in [bent_bar(), with_defects(bent_bar())] {
        for weights in [
            soft_weights(&surface, &[5, 40, 77, 60, 21]),
            soft_weights(&surface, &[9]),
            // Two handles that are one, and a handle that moves nothing.
            soft_weights(&surface, &[5, 40, 40]),
            soft_weights(&surface, &[5, 40]).insert_column(1, 0.0),
        ] {
            on_surface(name, stage, &surface, weights);
        }
    }
}

fn on_surface(name: &str, stage: &dyn Deformer, surface: &Surface, weights: DMatrix<f64>) {
    let handles = HandleWeights { matrix: weights, figures: Figures::default() };
    let regions = halves(surface);
    let skin = |handles: &HandleWeights, regions: &Regions| {
        stage.bind(surface).unwrap_or_else(|error| panic!("{name}: {error}")).skin(handles, regions)
    };
    let make = || skin(&handles, &regions).unwrap_or_else(|error| panic!("{name}: {error}"));
    let fit = |skin: &dyn Skin, pose: &[Point3<f64>]| skin.fit(pose).unwrap_or_else(|error| panic!("{name}: {error}"));
    let skinned = make();

    for seed in 0..5 {
        let motion = Random::new(seed).rigid_motion(surface.diagonal());
        let moved: Vec<_> = surface.positions.iter().map(|p| motion * p).collect();
        let found = fit(&*skinned, &moved);
        near(name, "a rigid motion is met", &found.positions, &moved);
        for (k, map) in found.transforms.iter().enumerate() {
            let off = (map - matrix(&motion)).amax();
            assert!(off < MAP_TOLERANCE, "{name}: the map of handle {k} is {off:e} off a rigid motion");
        }
    }

    let (pose, other) = (twisted(surface, 1.0), twisted(surface, -0.5));
    let first = fit(&*skinned, &pose);
    assert_eq!(first.transforms.len(), handles.matrix.ncols(), "{name}: one map a handle");
    assert!(first.transforms.iter().all(|map| map.iter().all(|x| x.is_finite())), "{name}: maps are finite");
    let blended = linear_blend(&handles.matrix, &first.transforms, &surface.positions);
    near(name, "positions are the blend of the maps", &first.positions, &blended.expect("as many maps as handles"));

    let same = |fit: Fit| fit.transforms == first.transforms && fit.positions == first.positions;
    fit(&*skinned, &other);
    assert!(same(fit(&*skinned, &pose)), "{name}: other maps after another pose");
    assert!(same(one_thread(|| fit(&*make(), &pose))), "{name}: other maps on one thread");

    assert!(skinned.fit(&pose[1..]).is_err(), "{name}: takes a pose with a vertex too few");
    let mut broken = pose;
    broken[3].y = f64::NAN;
    assert!(skinned.fit(&broken).is_err(), "{name}: takes a pose with NaN");
    let short = HandleWeights { matrix: handles.matrix.clone().remove_row(0), figures: Figures::default() };
    assert!(skin(&short, &regions).is_err(), "{name}: takes weights of another surface");
    let mut few = regions.clone();
    few.of_vertex.pop();
    assert!(skin(&handles, &few).is_err(), "{name}: takes regions of another surface");
}

/// Weights that fall off with the distance from the vertices `handles`, #V × #H; rows sum to 1.
pub(super) fn soft_weights(surface: &Surface, handles: &[usize]) -> DMatrix<f64> {
    let p = &surface.positions;
    let near = 0.01 * surface.diagonal().powi(2);
    let mut w = DMatrix::from_fn(p.len(), handles.len(), |i, k| 1.0 / (near + (p[i] - p[handles[k]]).norm_squared()));
    for mut row in w.row_iter_mut() {
        row /= row.sum();
    }
    w
}

/// Two regions, divided across the x axis.
fn halves(surface: &Surface) -> Regions {
    let of_vertex = surface.positions.iter().map(|p| u32::from(p.x > 0.0)).collect();
    Regions { of_vertex, count: 2, figures: Figures::default() }
}

fn matrix(motion: &Isometry3<f64>) -> Matrix3x4<f64> {
    motion.to_homogeneous().fixed_rows::<3>(0).into_owned()
}
