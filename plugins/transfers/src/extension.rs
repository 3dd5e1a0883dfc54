//! Deformation gradients of orphans from those of their neighbours.

use std::collections::{BTreeSet, HashMap, HashSet};

use mimesh_core::{
    Result,
    linalg::{Assembly, FixedUnknowns},
    mesh::Surface,
    operators::{Turn, logarithm, mean_quaternion, nearer},
};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use petgraph::unionfind::UnionFind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shore_motion::{BlendedMotion, ShoreMotion};

/// How triangles that correspond to nothing continue the deformation of their neighbours.
///
/// Both are harmonic extensions over the dual graph: they minimise Σ ‖h_t − h_u‖² over neighbours t, u with what corresponds held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Continuation {
    /// Rigid motions of shores (what lies together at the border of orphans), blended as screws, and gradients relative to them: what
    /// is twisted or bent between two shores keeps its width. Their rotations follow the turns of the source from triangle to
    /// triangle, past a half turn. With one shore it is `gradients`.
    #[default]
    Rotations,
    /// Deformation gradients themselves, as in Zhou et al. 2010, eq. 7: what is twisted shrinks, by half at 120 degrees.
    Gradients,
}

/// How the gradients of orphans are found.
pub struct OrphanRule<'a> {
    /// What is continued.
    pub continuation: Continuation,
    /// Pairs of triangles that count as neighbours as well.
    pub bridges: &'a [[u32; 2]],
    /// How strongly two neighbours are drawn to each other.
    pub weight: &'a dyn Fn(u32, u32) -> f64,
}

/// The harmonic extension to orphans over the dual graph, factored once.
#[derive(Debug)]
pub struct Extension {
    system: FixedUnknowns,
    /// Triangles next to orphans, then the orphans, in the order of the system's unknowns.
    triangles: Vec<u32>,
    /// How many of `triangles`, at the front, are held.
    held: usize,
    /// For each of `triangles` the connected region it lies in.
    region: Vec<u32>,
    /// Number of regions.
    regions: usize,
    /// For each of the held the shore it belongs to.
    shore: Vec<u32>,
    /// Number of shores.
    shores: usize,
    /// The motions of regions between several shores.
    motions: Vec<ShoreMotion>,
    /// Pairs of neighbours over an edge, one of the held and an orphan, by their places.
    beside: Vec<[usize; 2]>,
}

impl Extension {
    /// Factors the extension; `None` if there are no orphans.
    pub fn new(target: &Surface, is_orphan: impl Fn(u32) -> bool, rule: &OrphanRule<'_>) -> Result<Option<Self>> {
        let count = target.triangle_count();
        let orphans = (0..count as u32).filter(|&t| is_orphan(t));
        let mut edges = target.topology().adjacent;
        edges.extend(bridges_of_orphan_components(target, &is_orphan, rule.bridges));
        edges.extend(by_vertices(target, &edges));
        edges.retain(|&[a, b]| is_orphan(a) || is_orphan(b));
        let mut triangles: Vec<u32> = edges.iter().flatten().copied().chain(orphans).collect();
        triangles.sort_unstable_by_key(|&t| (is_orphan(t), t));
        triangles.dedup();
        let held = triangles.partition_point(|&t| !is_orphan(t));
        if held == triangles.len() {
            return Ok(None);
        }
        let mut number = vec![0; count];
        triangles.iter().enumerate().for_each(|(k, &t)| number[t as usize] = k as u32);
        let mut assembly = Assembly::new(triangles.len());
        for &[a, b] in &edges {
            let weight = (rule.weight)(a, b);
            assembly.add_outer(&[number[a as usize], number[b as usize]], &[[1.0], [-1.0]], weight);
        }
        let mut sets = UnionFind::<u32>::new(triangles.len());
        for &[a, b] in &edges {
            sets.union(number[a as usize], number[b as usize]);
        }
        // Orphans that no partner reaches have the identity: one of each such region is drawn to it.
        let mut reached: HashSet<u32> = (0..held as u32).map(|k| sets.find_mut(k)).collect();
        (held..triangles.len())
            .filter(|&k| reached.insert(sets.find_mut(k as u32)))
            .for_each(|k| assembly.add(k, k, 1.0));
        let fixed: Vec<u32> = (0..held as u32).collect();
        let system = FixedUnknowns::new(&assembly.finish(), &fixed, "the continuation of the deformation to orphans")?;
        let (region, regions) = numbered(sets.into_labeling());
        let (shore, shores) = shores(target, &triangles[..held]);
        let places = edges.iter().map(|edge| edge.map(|t| number[t as usize] as usize));
        let beside = places.filter_map(|[a, b]| match (a < held, b < held) {
            (true, false) => Some([a, b]),
            (false, true) => Some([b, a]),
            _ => None,
        });
        let beside = beside.collect();
        let mut extension = Self { system, triangles, held, region, regions, shore, shores, motions: vec![], beside };
        if rule.continuation == Continuation::Rotations {
            extension.motions = extension.motions(target, &is_orphan);
        }
        Ok(Some(extension))
    }

    /// The motions of regions between several shores, but for those that bridges lead to.
    fn motions(&self, target: &Surface, is_orphan: impl Fn(u32) -> bool) -> Vec<ShoreMotion> {
        let mut shores = vec![BTreeSet::new(); self.regions];
        self.region.iter().zip(&self.shore).for_each(|(&region, &shore)| _ = shores[region as usize].insert(shore));
        let shores: Vec<Vec<u32>> = shores.into_iter().map(|shores| shores.into_iter().collect()).collect();
        let most = shores.iter().map(Vec::len).max().unwrap_or(0);
        if most < 2 {
            return vec![];
        }
        // The share of the k-th shore of each region.
        let n = self.triangles.len();
        let mut values = Vec::with_capacity(most * self.held);
        for k in 0..most {
            let is_kth = |(&region, &shore): (&u32, &u32)| shores[region as usize].get(k) == Some(&shore);
            values.extend(self.region.iter().zip(&self.shore).map(|held| f64::from(u8::from(is_kth(held)))));
        }
        let share = self.system.solve(&vec![0.0; most * n], &values, most);
        let mut shore_of = HashMap::new();
        for (&t, &shore) in self.held().iter().zip(&self.shore) {
            target.triangles[t as usize].iter().for_each(|&v| _ = shore_of.insert(v, shore));
        }
        let bridged = orphan_components(target, is_orphan);
        let mut orphans = vec![Vec::new(); self.regions];
        for (place, &t) in self.triangles.iter().enumerate().skip(self.held) {
            orphans[self.region[place] as usize].push((place, t));
        }
        let regions = orphans.iter().zip(shores);
        let regions = regions.filter(|(orphans, _)| !orphans.iter().any(|(_, t)| bridged(*t)));
        let motion = |(orphans, shores): (&Vec<(usize, u32)>, Vec<u32>)| {
            ShoreMotion::new(target, orphans, shores, |place, k| share[k * n + place], |v| shore_of.get(&v).copied())
        };
        regions.filter_map(motion).collect()
    }

    /// The triangles that correspond and lie next to orphans.
    pub fn held(&self) -> &[u32] {
        &self.triangles[..self.held]
    }

    /// Continues the deformation gradients themselves.
    pub fn fill_gradients(&self, field: &mut [Matrix3<f64>]) {
        let n = self.triangles.len();
        // The nine entries of F − I, because what no partner reaches is drawn to 0.
        let mut values = Vec::with_capacity(9 * self.held);
        for (k, identity) in Matrix3::<f64>::identity().iter().enumerate() {
            values.extend(self.held().iter().map(|&t| field[t as usize][k] - identity));
        }
        let x = self.system.solve(&vec![0.0; 9 * n], &values, 9);
        for (place, &t) in self.triangles.iter().enumerate().skip(self.held) {
            field[t as usize] = Matrix3::from_fn(|i, j| x[(3 * j + i) * n + place]) + Matrix3::identity();
        }
    }

    /// Continues logarithms of the rotations of shores, relative to the mean rotation of each region so that a rigid motion of all
    /// does not matter; and F without its shore's rotation.
    ///
    /// `source_turns` has for each of [`held`](Self::held) the quaternion of its partner, whose sign its own takes; `axes` turns
    /// the axes of the source to those of the target.
    pub fn fill_rotations(
        &self,
        field: &mut [Matrix3<f64>],
        source_turns: &[UnitQuaternion<f64>],
        axes: &Matrix3<f64>,
    ) {
        let n = self.triangles.len();
        let turn = |(&t, of_source): (&u32, &UnitQuaternion<f64>)| {
            let turned = Quaternion::from_parts(of_source.w, axes * of_source.imag());
            nearer(&Turn::of(&field[t as usize]).quaternion, &UnitQuaternion::new_unchecked(turned))
        };
        let turns: Vec<UnitQuaternion<f64>> = self.held().iter().zip(source_turns).map(turn).collect();
        let means = |labels: &[u32], count: usize| {
            let mut all = vec![Vec::new(); count];
            turns.iter().zip(labels).for_each(|(turn, &label)| all[label as usize].push((1.0, *turn)));
            all.into_iter().map(|turns| mean_quaternion(turns.into_iter())).collect::<Vec<_>>()
        };
        let (middles, shores) = (means(&self.region, self.regions), means(&self.shore, self.shores));
        let middle = |place: usize| middles[self.region[place] as usize];
        let shore = |k: usize| shores[self.shore[k] as usize];

        let logarithms: Vec<Vector3<f64>> =
            (0..self.held).map(|k| logarithm(&(middle(k).inverse() * shore(k)))).collect();
        let back: Vec<Matrix3<f64>> = shores.iter().map(|q| q.inverse().to_rotation_matrix().into_inner()).collect();
        let without = |(&t, &shore): (&u32, &u32)| back[shore as usize] * field[t as usize] - Matrix3::identity();
        // What no partner reaches is drawn to 0, the identity.
        let mut rests: Vec<Matrix3<f64>> = self.held().iter().zip(&self.shore).map(without).collect();
        let mut motion = vec![None; n];
        let mut shears = vec![None; n];
        for region in &self.motions {
            let middle = middle(region.first_place());
            let logarithm = |shore: u32| logarithm(&(middle.inverse() * shores[shore as usize]));
            for BlendedMotion { place, gradient, shear } in region.at(&middle, logarithm) {
                motion[place] = Some(gradient);
                shears[place] = Some(shear);
            }
        }
        self.leave_out(&shears, &mut rests);
        let mut values = Vec::with_capacity(12 * self.held);
        (0..3).for_each(|axis| values.extend(logarithms.iter().map(|log| log[axis])));
        (0..9).for_each(|entry| values.extend(rests.iter().map(|rest| rest[entry])));
        let x = self.system.solve(&vec![0.0; 12 * n], &values, 12);
        for (place, &t) in self.triangles.iter().enumerate().skip(self.held) {
            let at = |column: usize| x[column * n + place];
            let turn = || middle(place) * UnitQuaternion::from_scaled_axis(Vector3::new(at(0), at(1), at(2)));
            let motion = motion[place].unwrap_or_else(|| turn().to_rotation_matrix().into_inner());
            let rest = Matrix3::from_fn(|i, j| at(3 + 3 * j + i)) + Matrix3::identity();
            field[t as usize] = motion * rest;
        }
    }

    /// Takes from what the shores have beside their rotations (`rests`, F − I) as much of the shear of the blended motion next to them
    /// as they have already: what is twisted on both sides of a shore is not to be twisted twice beside it.
    fn leave_out(&self, shears: &[Option<Matrix3<f64>>], rests: &mut [Matrix3<f64>]) {
        let mut fits = vec![(0.0, 0.0); self.shores];
        let mut beside = vec![(Matrix3::zeros(), 0.0); self.held];
        for &[k, orphan] in &self.beside {
            let Some(shear) = shears[orphan] else { continue };
            let (along, square) = &mut fits[self.shore[k] as usize];
            *along += rests[k].dot(&shear);
            *square += shear.norm_squared();
            beside[k].0 += shear;
            beside[k].1 += 1.0;
        }
        for (k, (sum, count)) in beside.iter().enumerate().filter(|(_, (_, count))| *count > 0.0) {
            let (along, square) = fits[self.shore[k] as usize];
            if square > 0.0 {
                rests[k] -= sum / *count * (along / square).clamp(0.0, 1.0);
            }
        }
    }
}

/// For each of the triangles `held` the shore it belongs to, a set that shares vertices, and the number of shores.
fn shores(target: &Surface, held: &[u32]) -> (Vec<u32>, usize) {
    let mut sets = UnionFind::<u32>::new(held.len());
    let mut first = vec![None; target.vertex_count()];
    for (k, &t) in held.iter().enumerate() {
        for &v in &target.triangles[t as usize] {
            sets.union(*first[v as usize].get_or_insert(k as u32), k as u32);
        }
    }
    numbered(sets.into_labeling())
}

/// Labels as numbers from 0, in their order, and how many there are.
fn numbered(mut labels: Vec<u32>) -> (Vec<u32>, usize) {
    let mut all = labels.clone();
    all.sort_unstable();
    all.dedup();
    labels.iter_mut().for_each(|label| *label = all.binary_search(label).unwrap_or_default() as u32);
    (labels, all.len())
}

/// The bridges that lead to a component of orphans alone: others have neighbours to continue.
fn bridges_of_orphan_components<'a>(
    target: &Surface,
    is_orphan: impl Fn(u32) -> bool,
    bridges: &'a [[u32; 2]],
) -> impl Iterator<Item = &'a [u32; 2]> {
    let lies_in_one = orphan_components(target, is_orphan);
    bridges.iter().filter(move |pair| pair.iter().any(|&t| lies_in_one(t)))
}

/// Whether a triangle lies in a component of orphans alone.
fn orphan_components(target: &Surface, is_orphan: impl Fn(u32) -> bool) -> impl Fn(u32) -> bool {
    let components = target.components();
    let component = move |t: u32| components.of_vertex[target.triangles[t as usize][0] as usize];
    let corresponds: HashSet<_> =
        (0..target.triangle_count() as u32).filter(|&t| !is_orphan(t)).map(&component).collect();
    move |t| !corresponds.contains(&component(t))
}

/// For each triangle without a neighbour over an edge, as one with a repeated corner, the triangle with which it shares most
/// vertices.
fn by_vertices(target: &Surface, edges: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut alone = vec![true; target.triangle_count()];
    edges.iter().flatten().for_each(|&t| alone[t as usize] = false);
    if !alone.contains(&true) {
        return vec![];
    }
    let around = target.triangles_around();
    let closest = |t: usize| {
        let others = target.triangles[t].iter().flat_map(|&v| &around[v as usize]).filter(|&&u| u as usize != t);
        let shared = |u: u32| target.triangles[t].iter().filter(|v| target.triangles[u as usize].contains(v)).count();
        others.copied().max_by_key(|&u| (shared(u), !alone[u as usize], std::cmp::Reverse(u)))
    };
    (0..alone.len()).filter(|&t| alone[t]).filter_map(|t| Some([t as u32, closest(t)?])).collect()
}
