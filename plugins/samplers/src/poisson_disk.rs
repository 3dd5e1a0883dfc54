//! Random points that keep apart, by sample elimination [Yuksel 2015].
//!
//! `oversampling` × `count` candidates are drawn evenly over the area; then the one that is most crowded by the others is removed
//! until `count` remain, crowding being Σ (1 − d / 2r)⁸ over candidates nearer than 2r, with r the greatest radius at which
//! `count` disks fit the area. Distances are straight, so that both sides of a thin sheet count as one.
//!
//! Every component with area keeps a point where `count` allows.

use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint},
    plugin::check_ranges,
    random::Random,
    register,
    stage::{AvailablePoints, Sampler},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ground::Ground;

register!(Sampler: PoissonDisk);

/// Random points that keep a distance from each other (sample elimination, Yuksel 2015).
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct PoissonDisk {
    /// Number of points.
    #[schemars(range(min = 1))]
    pub count: usize,
    /// Chooses the candidates.
    pub seed: u64,
    /// Candidates a point: the more, the more even are the distances.
    #[schemars(range(min = 1.0, max = 100.0))]
    pub oversampling: f64,
    /// Whether points lie at vertices, as handles of weights do, or anywhere within triangles.
    pub at_vertices: bool,
}

impl Default for PoissonDisk {
    fn default() -> Self {
        Self { count: 100, seed: 0, oversampling: 5.0, at_vertices: true }
    }
}

#[typetag::serde(name = "poisson_disk")]
impl Sampler for PoissonDisk {
    fn sample(&self, surface: &Surface) -> Result<Vec<SurfacePoint>> {
        check_ranges(self)?;
        let ground = Ground::new(surface)?;
        if self.at_vertices {
            ground.check(self.count)?;
        }
        let (candidates, area) = self.candidates(surface, &ground);
        let places: Vec<_> = candidates.iter().map(|c| c.position(surface, &surface.positions)).collect();
        let component = |point: &SurfacePoint| ground.component(point.corners(surface)[0].0);
        let components: Vec<usize> = candidates.iter().map(component).collect();
        let keep_components = ground.component_count <= self.count;
        let radius = (area / (2.0 * 3f64.sqrt() * self.count as f64)).sqrt();
        let kept = eliminate(&places, &components, keep_components, radius, self.count);
        Ok(kept.into_iter().map(|k| candidates[k]).collect())
    }

    fn sample_available(&self, surface: &Surface) -> Result<AvailablePoints> {
        check_ranges(self)?;
        // Within triangles there are places without end.
        let places = if self.at_vertices { Ground::new(surface)?.vertices.len() } else { self.count };
        let points = Self { count: self.count.min(places), ..self.clone() }.sample(surface)?;
        Ok(AvailablePoints { points, asked: self.count })
    }
}

impl PoissonDisk {
    /// Candidates spread evenly over the area, with one on each component, and the area.
    fn candidates(&self, surface: &Surface, ground: &Ground) -> (Vec<SurfacePoint>, f64) {
        let mut random = Random::new(self.seed);
        let normals = surface.area_normals(&surface.positions);
        let mut sum = 0.0;
        let mut sums: Vec<f64> = Vec::with_capacity(ground.triangles.len());
        for &t in &ground.triangles {
            sum += normals[t as usize].norm() / 2.0;
            sums.push(sum);
        }
        let wanted = (self.oversampling * self.count as f64).ceil() as usize;
        let mut triangles: Vec<u32> = Vec::with_capacity(wanted + ground.component_count);
        let mut has_one = vec![false; ground.all_components()];
        for &t in &ground.triangles {
            if !std::mem::replace(&mut has_one[ground.component(surface.triangles[t as usize][0])], true) {
                triangles.push(t);
            }
        }
        triangles.extend((0..wanted).map(|_| {
            let place = random.unit() * sum;
            ground.triangles[sums.partition_point(|&s| s <= place).min(sums.len() - 1)]
        }));
        let mut points: Vec<SurfacePoint> = triangles
            .into_iter()
            .map(|t| {
                let (u, v) = (random.unit().sqrt(), random.unit());
                SurfacePoint::Triangle(t, [1.0 - u, u * (1.0 - v), u * v])
            })
            .collect();
        if self.at_vertices {
            let nearest = |point: &SurfacePoint| {
                let corners = point.corners(surface);
                corners.iter().fold(corners[0], |best, &c| if c.1 > best.1 { c } else { best }).0
            };
            let mut vertices: BTreeSet<u32> = points.iter().map(nearest).collect();
            if vertices.len() < self.count {
                vertices.extend(&ground.vertices);
            }
            points = vertices.into_iter().map(SurfacePoint::Vertex).collect();
        }
        (points, sum)
    }
}

/// A candidate in the queue, most crowded first, ties by number.
#[derive(PartialEq)]
struct Crowded(f64, usize);

impl Eq for Crowded {}

impl PartialOrd for Crowded {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Crowded {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(other.1.cmp(&self.1))
    }
}

/// Removes the most crowded of `places` until `count` remain, of each component one if `keep_components`.
fn eliminate(
    places: &[Point3<f64>],
    components: &[usize],
    keep_components: bool,
    radius: f64,
    count: usize,
) -> Vec<usize> {
    let reach = 2.0 * radius;
    let neighbours = neighbours(places, reach);
    // Candidates closer than the closest that can be expected of the result crowd each other no more than at that distance.
    let ratio = count as f64 / places.len() as f64;
    let closest = radius * 0.65 * (1.0 - ratio.min(1.0).powf(1.5));
    let crowding = |a: usize, b: usize| {
        let distance = (places[b] - places[a]).norm().max(closest).min(reach);
        (1.0 - distance / reach).powi(8)
    };
    let mut weight: Vec<f64> = (0..places.len()).map(|a| neighbours[a].iter().map(|&b| crowding(a, b)).sum()).collect();
    let mut left = BTreeMap::<usize, usize>::new();
    components.iter().for_each(|&c| *left.entry(c).or_default() += 1);
    let mut queue: BinaryHeap<_> = weight.iter().enumerate().map(|(k, &w)| Crowded(w, k)).collect();
    let mut is_kept = vec![true; places.len()];
    let mut remaining = places.len();
    while remaining > count {
        let Some(Crowded(w, k)) = queue.pop() else { break };
        // Entries that are out of date have a successor in the queue.
        if !is_kept[k] || w != weight[k] {
            continue;
        }
        let of_component = left.entry(components[k]).or_default();
        if keep_components && *of_component == 1 {
            continue;
        }
        *of_component -= 1;
        is_kept[k] = false;
        remaining -= 1;
        for &b in neighbours[k].iter().filter(|&&b| is_kept[b]) {
            weight[b] -= crowding(k, b);
            queue.push(Crowded(weight[b], b));
        }
    }
    (0..places.len()).filter(|&k| is_kept[k]).collect()
}

/// For each place the others within `reach`, by a grid of cells of that size.
fn neighbours(places: &[Point3<f64>], reach: f64) -> Vec<Vec<usize>> {
    let cell = |p: &Point3<f64>| [p.x, p.y, p.z].map(|x| (x / reach).floor() as i64);
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    places.iter().enumerate().for_each(|(k, p)| cells.entry(cell(p)).or_default().push(k));
    let around = |(k, p): (usize, &Point3<f64>)| {
        let [x, y, z] = cell(p);
        let steps = (0..27).map(|s| [x + s % 3 - 1, y + s / 3 % 3 - 1, z + s / 9 - 1]);
        let near = steps.filter_map(|c| cells.get(&c)).flatten().copied();
        near.filter(|&b| b != k && (places[b] - p).norm() < reach).collect()
    };
    places.iter().enumerate().map(around).collect()
}
