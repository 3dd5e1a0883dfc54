//! Fits maps of handles to a pose, as rigid within regions as possible.
//!
//! Minimises E = λ E_arap + E_diff (Yang et al. 2018, eqs. 3 to 5) over affine maps T of the handles and rotations R of regions:
//!
//! E_arap = Σ_g Σ over spokes (i, j) of vertices i of region g: w̃ᵢⱼ ‖(qᵢ − qⱼ) − R_g (pᵢ − pⱼ)‖², w̃ᵢⱼ = ½ (cot αᵢⱼ + cot βᵢⱼ),
//! E_diff = Σᵢ dᵢ ‖qᵢ − q′ᵢ‖², with q the linear blend of T,
//!
//! by turns for T and for R. Each undirected edge is a spoke of both its ends.
//!
//! Departures: T minimises E itself, so that E never rises, where eq. 18 minimises another sum (`global_step: stacked` for
//! that); negative weights of edges count as 0, without which a rigid motion need not be a minimum
//! (`edge_weights: signed_cotangent` for the paper's); a region turned inside out takes the nearest rotation, not a negated matrix; maps that the pose leaves open, as across
//! a flat region, are drawn to the rigid motion of what their handle moves (`regularisation`).
//!
//! λ has no unit and does not change with the scale of the mesh, for both terms are squared lengths. It does change with its
//! resolution: E_diff grows with the number of vertices and E_arap, a Dirichlet energy, does not. That is the paper's meaning
//! and kept.
//!
//! Cost, for h handles: per surface O(#V); per set of handles O(#V h²) and one Cholesky factorisation of 4h × 4h, shared by the
//! three coordinates (Jacobson et al. 2012); per pose O(#V h), and per iteration O(h²) and a polar decomposition a region.

use std::sync::Arc;

use mimesh_core::{
    Error, Result,
    mesh::Surface,
    operators::voronoi_mass,
    plugin::check_ranges,
    register,
    stage::{BoundDeformer, Deformer, Fit, HandleWeights, Regions, Skin},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::edges::EdgeWeights;
use crate::{
    alternation::{Energy, GlobalSystem, Reduced, Stop, alternate},
    covariances::Covariances,
    edges::Edges,
    handle_space::symmetric_product,
    handles::Handles,
    reference::RestShape,
};

register!(Deformer: ArapSkinning);

/// Fits affine maps of handles to a pose, as rigid within regions as possible (Yang et al. 2018, eq. 5).
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ArapSkinning {
    /// λ: how much rigidity within regions counts against closeness to the pose. Independent of the scale of the mesh; a mesh
    /// with twice the vertices needs twice the λ for the same result.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub lambda: f64,
    /// The vertices that are drawn to the pose, and how strongly.
    pub difference: Difference,
    /// Weights of edges in the rigidity.
    pub edge_weights: EdgeWeights,
    /// The energy that the maps minimise while rotations are fixed.
    pub global_step: GlobalStep,
    /// How strongly each handle is drawn to the best rigid motion of what it moves, relative to its share of the closeness to
    /// the pose. It decides where a region is flatter than about the square root of this times its size; 1e-12 is the paper's
    /// energy alone. On bodies, 1e-3 comes as near to the source's poses as that and carries a little better to other bodies.
    #[schemars(range(min = 1e-12, max = 1.0))]
    pub regularisation: f64,
    /// Stops when an iteration lowers the energy by less than this part of it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tolerance: f64,
    /// Most iterations a pose.
    #[schemars(range(min = 1))]
    pub max_iterations: usize,
}

impl Default for ArapSkinning {
    fn default() -> Self {
        Self {
            lambda: 0.5,
            difference: Difference::Uniform,
            edge_weights: EdgeWeights::Cotangent,
            global_step: GlobalStep::Exact,
            regularisation: 1e-3,
            tolerance: 1e-5,
            max_iterations: 100,
        }
    }
}

/// The vertices that are drawn to the pose: the weights d of E_diff.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Difference {
    /// All vertices alike, as in the paper.
    #[default]
    Uniform,
    /// Each vertex by the area about it, with mean 1: closeness does not depend on how finely a region is meshed.
    Area,
    /// E_diff is off: only the vertex that each handle moves most is held at its place in the pose, as in Jacobson et al. 2012.
    /// (Held to nothing, any rigid motion would be a minimum.)
    None,
}

/// The energy that the maps minimise while rotations are fixed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GlobalStep {
    /// E itself.
    #[default]
    Exact,
    /// The squared residual of [λL; I] q = [λb; q′] (the paper's eq. 18), under which E may rise.
    Stacked,
}

/// How strongly a vertex is held, where E_diff is off, against edges of weight λ.
const HOLD_WEIGHT: f64 = 1e3;

#[typetag::serde(name = "arap_skinning")]
impl Deformer for ArapSkinning {
    fn bind(&self, surface: &Surface) -> Result<Box<dyn BoundDeformer>> {
        self.bind_coarse(surface, &vec![1.0; surface.vertex_count()])
    }

    fn bind_coarse(&self, surface: &Surface, counts: &[f64]) -> Result<Box<dyn BoundDeformer>> {
        check_ranges(self)?;
        Error::check_shape("counts of vertices (#V)", surface.vertex_count(), counts.len())?;
        Ok(Box::new(Bound {
            settings: self.clone(),
            edges: Edges::new(surface, self.edge_weights),
            closeness: closeness(surface, counts, self.difference),
            rest: Arc::new(RestShape::new(&surface.positions)),
            surface: surface.clone(),
        }))
    }
}

/// d, #V, whose sum is that of `counts` (or 0 where E_diff is off).
fn closeness(surface: &Surface, counts: &[f64], difference: Difference) -> Vec<f64> {
    match difference {
        Difference::Uniform => counts.to_vec(),
        Difference::None => vec![0.0; counts.len()],
        Difference::Area => {
            let mass = voronoi_mass(&surface.positions, &surface.triangles);
            let (total, count): (f64, f64) = (mass.iter().sum(), counts.iter().sum());
            if total > 0.0 { mass.iter().map(|m| m * count / total).collect() } else { counts.to_vec() }
        }
    }
}

#[derive(Clone, Debug)]
struct Bound {
    settings: ArapSkinning,
    surface: Surface,
    edges: Edges,
    closeness: Vec<f64>,
    rest: Arc<RestShape>,
}

impl BoundDeformer for Bound {
    fn skin(&self, weights: &HandleWeights, regions: &Regions) -> Result<Box<dyn Skin>> {
        let ArapSkinning { lambda, difference, global_step, regularisation, tolerance, max_iterations, .. } =
            self.settings;
        regions.check(self.surface.vertex_count())?;
        let (mut closeness, mut regularisation) = (self.closeness.clone(), regularisation);
        if difference == Difference::None {
            held(weights)
                .into_iter()
                .for_each(|v| closeness[v] = if lambda > 0.0 { HOLD_WEIGHT * lambda } else { HOLD_WEIGHT });
            // Relative to λ, that is; against the rigidity a share of what holds would be much.
            regularisation = (regularisation / HOLD_WEIGHT).max(1e-12);
        }
        let handles = Handles::new(&self.rest, weights, closeness, regularisation)?;
        let space = &handles.space;
        let quadratic = space.symmetric_product(&space.laplacian(&self.edges, 2.0 * lambda, &handles.closeness));
        let covariances = Covariances::new(space.rows(), &self.edges, &self.surface, regions);
        let system = match global_step {
            GlobalStep::Exact => GlobalSystem::new(quadratic.clone(), &handles.ridge, &(&covariances.of_maps * lambda)),
            GlobalStep::Stacked => {
                let residual = space.laplacian(&self.edges, lambda, &vec![0.0; handles.closeness.len()]);
                let closeness = space.laplacian(&self.edges, 0.0, &handles.closeness);
                let matrix = symmetric_product(&residual, &residual) + space.symmetric_product(&closeness);
                // λb = ½ λ Σⱼ (R_g(i) + R_g(j)) w̃ᵢⱼ (pᵢ − pⱼ).
                let of_residual = Covariances::new(&residual, &self.edges, &self.surface, regions).of_maps;
                GlobalSystem::new(matrix, &handles.ridge, &(of_residual * (0.5 * lambda)))
            }
        }?;
        let energy = Energy { lambda, quadratic, covariances, ridge: handles.ridge.clone() };
        Ok(Box::new(Skinned {
            reduced: Reduced::new(&energy, &system, global_step == GlobalStep::Exact),
            energy,
            system,
            handles,
            regions: regions.clone(),
            stop: Stop { tolerance, max_iterations },
        }))
    }
}

/// For each handle the vertex that it moves most.
fn held(weights: &HandleWeights) -> Vec<usize> {
    weights.matrix.column_iter().map(|column| column.argmax().0).collect()
}

#[derive(Clone, Debug)]
struct Skinned {
    handles: Handles,
    energy: Energy,
    system: GlobalSystem,
    reduced: Reduced,
    regions: Regions,
    stop: Stop,
}

impl Skin for Skinned {
    fn fit(&self, posed: &[Point3<f64>]) -> Result<Fit> {
        let (seen, goal) = self.handles.see(posed)?;
        let rotations = self.handles.rest.rotations(&seen.displacements, &self.regions);
        let minimum = alternate(&self.energy, &self.system, &self.reduced, &goal, rotations, self.stop);
        let mut fit = self.handles.fit(&seen, &minimum.maps);
        let figures = &mut fit.figures;
        figures.set("energy", minimum.energies[minimum.energies.len() - 1] - minimum.ridge_energy);
        figures.set("iterations", minimum.energies.len() - 1);
        figures.set("converged", minimum.converged);
        figures.set("energies", minimum.energies);
        Ok(fit)
    }
}
