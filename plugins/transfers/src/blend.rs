//! Several transfers, each for a part of the target.
//!
//! Each part k has a weight φₖ at each vertex: 1 where only its own region is within reach, falling smoothly to 0 at the distance
//! `border` from its region; Σₖ φₖ = 1. Results of two methods do not lie at the same place, and mixing positions would
//! shear what lies between. So components with vertices of several weights take the mean of the deformation gradients Fₖ by φₖ
//! (of logarithms of rotations and of stretches, so that parts that turn apart do not shrink), integrated over the component, with the mean of Σₖ φₖ xₖ over it. A component of one part takes that part's positions as they
//! are.
//!
//! Rest gives rest and a rigid motion itself: all parts then have the same gradients and the same means.

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, check_finite},
    operators::{DeformationGradients, mean_gradient, voronoi_mass},
    plugin::check_ranges,
    register,
    spatial::EdgePaths,
    stage::{BindInput, BoundTransfer, ComponentRef, Motion, Transfer, TransferPair, Transferred},
};
use nalgebra::{Matrix3, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::debug_span;

use crate::{
    frames::{Frames, evenly_spaced},
    gradient::GradientTransfer,
    poisson::{Fit, Poisson},
};

register!(Transfer: Blend);

/// Several transfers, each for a part of the target: the body by one, the face by another.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Blend {
    /// The transfers and their parts. Every transfer is bound to the whole target.
    pub parts: Vec<Part>,
    /// Within this distance of another part a part's weight falls off, in diagonals of the target, along the surface and over
    /// the gaps of `proximity:`; 0 for a hard border.
    #[schemars(range(min = 0.0))]
    pub border: f64,
}

/// A transfer and the part of the target that it is for.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Moves the part.
    pub transfer: Box<dyn Transfer>,
    /// Components by number, or objects, groups and materials by name, which may be regions of a connected surface; without any,
    /// all that no other part names.
    #[serde(default)]
    pub components: Vec<ComponentRef>,
}

impl Default for Blend {
    fn default() -> Self {
        Self { parts: vec![Part { transfer: Box::new(GradientTransfer::default()), components: vec![] }], border: 0.02 }
    }
}

#[typetag::serde(name = "blend")]
impl Transfer for Blend {
    fn needs_correspondence(&self) -> bool {
        self.parts.iter().any(|part| part.transfer.needs_correspondence())
    }

    fn markers_needed(&self) -> usize {
        self.parts.iter().map(|part| part.transfer.markers_needed()).max().unwrap_or(0)
    }

    fn gives_motion(&self) -> bool {
        self.parts.iter().any(|part| part.transfer.gives_motion())
    }

    fn poses_wanted(&self) -> usize {
        self.parts.iter().map(|part| part.transfer.poses_wanted()).max().unwrap_or(0)
    }

    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        check_ranges(self)?;
        let target = input.pair.target;
        let weights = self.weights(input.pair)?;
        let mut figures = Figures::default();
        let mut parts = Vec::with_capacity(self.parts.len());
        for (k, (part, weights)) in self.parts.iter().zip(&weights).enumerate() {
            let seen = evenly_spaced(input.poses, part.transfer.poses_wanted());
            let count = self.parts.len() as f64;
            let work = input.work.part(k as f64 / count, (k + 1) as f64 / count);
            let input = BindInput { poses: &seen, work, ..input };
            let span = debug_span!("transfer", "type" = part.transfer.typetag_name());
            let bound = span.in_scope(|| part.transfer.bind(input)).map_err(|error| at(k, error))?;
            let of_part = bound.figures();
            of_part.values.into_iter().for_each(|(name, value)| figures.set(&format!("{}_{name}", k + 1), value));
            figures.warnings.extend(of_part.warnings);
            figures.set(&format!("{}_vertices", k + 1), weights.iter().filter(|&&w| w > 0.0).count());
            parts.push(bound);
        }
        let members = Members::new(target, &weights);
        let poisson = if members.mixed.is_empty() { None } else { Some(Poisson::new(target, |area| area)?) };
        Ok(Box::new(Bound {
            parts,
            gradients: DeformationGradients::new(&target.positions, &target.triangles),
            triangles: target.triangles.clone(),
            weights,
            members,
            poisson,
            figures,
        }))
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        check_ranges(self)?;
        self.regions(pair.target)?;
        self.parts.iter().enumerate().try_for_each(|(k, part)| part.transfer.check(pair).map_err(|error| at(k, error)))
    }
}

/// The error of part `k`.
fn at(k: usize, error: Error) -> Error {
    match error {
        Error::Data { message, hint } => Error::Data { message: format!("parts[{k}]: {message}"), hint },
        other => other,
    }
}

impl Blend {
    /// The part of each triangle (#F of the target).
    fn regions(&self, target: &Surface) -> Result<Vec<usize>> {
        let components = target.components();
        let mut region = vec![None; target.triangle_count()];
        let mut others = None;
        for (k, part) in self.parts.iter().enumerate() {
            if part.components.is_empty() && others.replace(k).is_some() {
                return Err(Error::data(
                    "two parts name no components, so that both are for all that no other part names",
                    "give all parts but one `components: [ … ]`",
                ));
            }
            for which in &part.components {
                let numbers = which.resolve(target, &components).map_err(|error| at(k, error))?;
                for t in triangles(which, target, |t| {
                    components.of_vertex[target.triangles[t][0] as usize].is_some_and(|c| numbers.contains(&c))
                }) {
                    match region[t] {
                        Some(other) if other != k => {
                            return Err(Error::data(
                                format!(
                                    "polygon {} (from 0) belongs to parts[{other}] and to parts[{k}]",
                                    target.polygon_of[t]
                                ),
                                "name each component, object, group or material in one part only",
                            ));
                        }
                        _ => region[t] = Some(k),
                    }
                }
            }
        }
        let missing = || {
            Error::data(
                "some polygons belong to no part of the blend",
                "leave out `components` of one part: it is then for all that no other part names",
            )
        };
        region.into_iter().map(|k| k.or(others).ok_or_else(missing)).collect()
    }

    /// φ of each part at each vertex (#V of the target).
    fn weights(&self, pair: TransferPair<'_>) -> Result<Vec<Vec<f64>>> {
        let target = pair.target;
        let regions = self.regions(target)?;
        let width = self.border * target.diagonal();
        let bridges: Vec<[u32; 2]> = pair.proximity.iter().flat_map(|graph| graph.pairs()).collect();
        let paths = EdgePaths::new(&target.positions, &target.triangles, &bridges);
        let weight = |k: usize| -> Vec<f64> {
            let own = target.triangles.iter().zip(&regions).filter(|(_, region)| **region == k);
            let mut own: Vec<u32> = own.flat_map(|(corners, _)| corners).copied().collect();
            own.sort_unstable();
            own.dedup();
            let mut inside = vec![f64::INFINITY; target.vertex_count()];
            own.iter().for_each(|&v| inside[v as usize] = 0.0);
            let distances = if width > 0.0 { paths.distances(&own) } else { inside };
            let fall = |d: f64| if d == 0.0 { 1.0 } else { (1.0 - d / width).max(0.0) };
            // 3u² − 2u³ has no kink at either end.
            distances.into_iter().map(fall).map(|u| u * u * (3.0 - 2.0 * u)).collect()
        };
        let mut weights: Vec<Vec<f64>> = (0..self.parts.len()).map(weight).collect();
        for v in 0..target.vertex_count() {
            let total: f64 = weights.iter().map(|w| w[v]).sum();
            // Vertices without a triangle have no part and follow their neighbours.
            if total > 0.0 {
                weights.iter_mut().for_each(|w| w[v] /= total);
            }
        }
        Ok(weights)
    }
}

/// The triangles meant: those of the name itself where the mesh has it, else those `within` the components meant.
fn triangles(which: &ComponentRef, target: &Surface, within: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut called = Vec::new();
    if let ComponentRef::Name(name) = which {
        if let Some(part) = target.part_names.iter().position(|other| other == name) {
            called.extend((0..target.triangle_count()).filter(|&t| target.part_of[t] as usize == part));
        }
        let others = target.other_names.iter().filter(|(other, _)| other == name);
        called.extend(others.flat_map(|(_, runs)| runs).flat_map(|run| run.clone().map(|t| t as usize)));
    }
    if called.is_empty() { (0..target.triangle_count()).filter(|&t| within(t)).collect() } else { called }
}

/// Vertices of components, by what their weights say.
#[derive(Debug)]
struct Members {
    /// For each vertex the part that it takes its position from, unless its component is mixed.
    part: Vec<usize>,
    /// Components with vertices of several weights: their vertices with shares of the area that sum to 1.
    mixed: Vec<Vec<(u32, f64)>>,
}

impl Members {
    fn new(target: &Surface, weights: &[Vec<f64>]) -> Self {
        let components = target.components();
        let mass = voronoi_mass(&target.positions, &target.triangles);
        let mut vertices = vec![Vec::new(); components.count()];
        for v in 0..target.vertex_count() {
            if let Some(c) = components.of_vertex[v] {
                vertices[c as usize].push(v as u32);
            }
        }
        let of = |v: u32| weights.iter().position(|w| w[v as usize] == 1.0);
        let mut part = vec![0; target.vertex_count()];
        let mut mixed = Vec::new();
        for vertices in vertices {
            match vertices.first().and_then(|&first| of(first)) {
                Some(k) if vertices.iter().all(|&v| of(v) == Some(k)) => {
                    vertices.iter().for_each(|&v| part[v as usize] = k);
                }
                _ => {
                    let total: f64 = vertices.iter().map(|&v| mass[v as usize]).sum();
                    let even = 1.0 / vertices.len() as f64;
                    let share = |&v: &u32| (v, if total > 0.0 { mass[v as usize] / total } else { even });
                    mixed.push(vertices.iter().map(share).collect());
                }
            }
        }
        Self { part, mixed }
    }
}

#[derive(Debug)]
struct Bound {
    parts: Vec<Box<dyn BoundTransfer>>,
    gradients: DeformationGradients,
    triangles: Vec<[u32; 3]>,
    /// φ of each part at each vertex.
    weights: Vec<Vec<f64>>,
    members: Members,
    /// The system to integrate gradients with; `None` if no component is mixed.
    poisson: Option<Poisson>,
    figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        self.transfer_all(&[posed]).pop().expect("one pose has one result")
    }

    fn bytes(&self, poses: usize) -> u64 {
        let of_parts: u64 = self.parts.iter().map(|part| part.bytes(poses)).sum();
        of_parts + self.poisson.as_ref().map_or(0, |poisson| poisson.bytes(poses))
    }

    fn at_once(&self) -> usize {
        let of_parts = self.parts.iter().map(|part| part.at_once());
        of_parts.chain(self.poisson.as_ref().map(Poisson::at_once)).max().unwrap_or(1)
    }

    fn transfer_all(&self, poses: &[&[Point3<f64>]]) -> Vec<Result<Transferred>> {
        let mut of_poses: Vec<Result<Vec<Transferred>>> = poses.iter().map(|_| Ok(vec![])).collect();
        for part in &self.parts {
            for (results, result) in of_poses.iter_mut().zip(part.transfer_all(poses)) {
                match (results.as_mut(), result) {
                    (Ok(results), Ok(result)) => results.push(result),
                    (Ok(_), Err(error)) => *results = Err(error),
                    (Err(_), _) => {}
                }
            }
        }
        self.blend_all(of_poses)
    }

    fn motion(&self) -> Option<Box<dyn Motion + '_>> {
        Some(Box::new(InMotion { bound: self, parts: Frames::of(self.parts.iter().map(|part| &**part))? }))
    }

    fn figures(&self) -> Figures {
        self.figures.clone()
    }
}

struct InMotion<'a> {
    bound: &'a Bound,
    parts: Vec<Frames<'a>>,
}

impl Motion for InMotion<'_> {
    fn frame(&mut self, frame: usize, posed: &[Point3<f64>]) -> Result<Transferred> {
        let results = self.parts.iter_mut().map(|part| part.frame(frame, posed)).collect();
        self.bound.blend_all(vec![results]).pop().expect("one frame has one result")
    }
}

impl Bound {
    /// The blend of the parts' results, for each pose.
    fn blend_all(&self, of_poses: Vec<Result<Vec<Transferred>>>) -> Vec<Result<Transferred>> {
        let Some(poisson) = &self.poisson else {
            return of_poses.into_iter().map(|results| self.blend(results?, None)).collect();
        };
        let field = |results: &Vec<Transferred>| (0..self.triangles.len()).map(|t| self.gradient(t, results)).collect();
        let fields: Vec<Vec<Matrix3<f64>>> = of_poses.iter().flatten().map(field).collect();
        let fields: Vec<&[Matrix3<f64>]> = fields.iter().map(Vec::as_slice).collect();
        let mut solutions = poisson.solve_all(&fields, Fit::LEAST_SQUARES).into_iter();
        let blend = |results: Result<Vec<Transferred>>| {
            let results = results?;
            self.blend(results, Some(solutions.next().expect("each field has a solution")?.positions))
        };
        of_poses.into_iter().map(blend).collect()
    }

    /// The blend of the parts' results, given their mean gradients integrated where a component is mixed.
    fn blend(&self, results: Vec<Transferred>, integrated: Option<Vec<Point3<f64>>>) -> Result<Transferred> {
        let mut positions: Vec<_> =
            self.members.part.iter().enumerate().map(|(v, &k)| results[k].positions[v]).collect();
        if let Some(integrated) = integrated {
            for members in &self.members.mixed {
                let goal: Vector3<f64> = members.iter().map(|&(v, share)| self.mean(v, &results) * share).sum();
                let found: Vector3<f64> = members.iter().map(|&(v, share)| integrated[v as usize].coords * share).sum();
                members.iter().for_each(|&(v, _)| positions[v as usize] = integrated[v as usize] + (goal - found));
            }
        }
        check_finite(&positions)?;
        let mut figures = Figures::default();
        for (k, result) in results.into_iter().enumerate() {
            let values = result.figures.values.into_iter();
            values.for_each(|(name, value)| figures.set(&format!("{}_{name}", k + 1), value));
            figures.warnings.extend(result.figures.warnings);
        }
        Ok(Transferred { positions, figures })
    }

    /// Σₖ φₖ xₖ.
    fn mean(&self, v: u32, results: &[Transferred]) -> Vector3<f64> {
        let one = |(w, result): (&Vec<f64>, &Transferred)| result.positions[v as usize].coords * w[v as usize];
        self.weights.iter().zip(results).map(one).sum()
    }

    /// The mean of the parts' gradients by φ, that of the corners; rotations and stretches apart.
    fn gradient(&self, t: usize, results: &[Transferred]) -> Matrix3<f64> {
        let corners = self.triangles[t];
        let of_part = |(weights, result): (&Vec<f64>, &Transferred)| {
            let weight = corners.iter().map(|&v| weights[v as usize]).sum::<f64>() / 3.0;
            (weight > 0.0).then(|| (weight, self.gradients.of_triangle(t, &result.positions)))
        };
        mean_gradient(&self.weights.iter().zip(results).filter_map(of_part).collect::<Vec<_>>())
    }
}
