//! A surface as its limbs.

use mimesh_core::{Result, mesh::Surface, spatial::EdgePaths, stage::Sampler};
use nalgebra::Point3;
use rayon::prelude::*;

use super::{
    cloud::Cloud,
    limbs::{Limb, limbs},
    links::paths,
};

/// A surface as limbs are found and compared on it.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its points.
    pub cloud: Cloud,
    /// The mean distance of each point along the surface, relative to the mean over all points, #P.
    pub far: Vec<f64>,
    /// Its limbs, greatest first.
    pub limbs: Vec<Limb>,
    /// The longest distance from a tip.
    pub longest: f64,
}

impl Shape {
    /// The shape of `surface`, with mean distances to `sources` points and limbs that stand out by at least `persistence`.
    ///
    /// # Errors
    ///
    /// Those of [`Cloud::new`].
    pub fn new(surface: &Surface, sampler: &dyn Sampler, sources: usize, persistence: f64) -> Result<Self> {
        let cloud = Cloud::new(surface, sampler)?;
        let paths = paths(&cloud);
        let far = mean_distances(&paths, &cloud.places, sources);
        let limbs = limbs(&paths, &far, persistence);
        let longest = limbs.iter().flat_map(|limb| &limb.distances).copied().fold(0.0, f64::max);
        Ok(Self { cloud, far, limbs, longest })
    }

    /// The distance between the tips of two limbs, relative to the longest.
    pub fn between(&self, a: usize, b: usize) -> f64 {
        self.limbs[a].distances[self.limbs[b].tip] / self.longest
    }
}

/// The mean distance of each point to `count` others that are spread evenly, relative to the mean over all points.
fn mean_distances(paths: &EdgePaths, places: &[Point3<f64>], count: usize) -> Vec<f64> {
    let sources = farthest(paths, places, count);
    let all: Vec<Vec<f64>> = sources.par_iter().map(|&source| paths.distances(&[source])).collect();
    let mut sums = vec![0.0; places.len()];
    for distances in &all {
        sums.iter_mut().zip(distances).for_each(|(sum, distance)| *sum += distance);
    }
    let mean = sums.iter().sum::<f64>() / sums.len() as f64;
    if mean > 0.0 {
        sums.iter_mut().for_each(|sum| *sum /= mean);
    }
    sums
}

/// At most `count` points, each the farthest along `paths` from those before, the first the farthest from the middle.
fn farthest(paths: &EdgePaths, places: &[Point3<f64>], count: usize) -> Vec<u32> {
    let sum: nalgebra::Vector3<f64> = places.iter().map(|p| p.coords).sum();
    let middle = Point3::from(sum / places.len() as f64);
    let greatest = |values: &[f64]| (0..values.len()).reduce(|best, v| if values[v] > values[best] { v } else { best });
    let from_middle: Vec<f64> = places.iter().map(|p| (p - middle).norm()).collect();
    let mut nearest = vec![f64::INFINITY; places.len()];
    let mut sources: Vec<u32> = Vec::new();
    let mut next = greatest(&from_middle);
    while let Some(source) = next.filter(|_| sources.len() < count.min(places.len())) {
        sources.push(source as u32);
        paths.shorten(&mut nearest, source as u32);
        next = greatest(&nearest);
    }
    sources
}
