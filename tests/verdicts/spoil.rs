//! Ways to spoil markers and results.

use mimesh::core::{
    mesh::{Surface, SurfacePoint},
    testkit::random::Random,
};
use nalgebra::{Point3, Vector3};

use crate::cases::{Case, Positions};

/// Markers that are wrong, by the name of the fault; x runs across every mesh.
pub fn markers(case: &Case, target: &Surface) -> Vec<(&'static str, Vec<(SurfacePoint, SurfacePoint)>)> {
    if case.markers.len() < 8 {
        return vec![];
    }
    let good = &case.markers;
    let s = |k: usize| good[k].0.position(&case.source, &case.source.positions);
    let t = |k: usize| good[k].1.position(target, &target.positions);
    let middle = |positions: &[Point3<f64>]| {
        let x = || positions.iter().map(|p| p.x);
        (x().fold(f64::INFINITY, f64::min) + x().fold(f64::NEG_INFINITY, f64::max)) / 2.0
    };
    let across = middle(&case.source.positions);
    let mirror = |k: usize| {
        let there = Point3::new(2.0 * across - s(k).x, s(k).y, s(k).z);
        (0..good.len()).min_by(|&a, &b| (s(a) - there).norm().total_cmp(&(s(b) - there).norm())).unwrap()
    };
    // The lowest pair that has another one across.
    let height = |k: usize| s(k).y;
    let sided =
        (0..good.len()).filter(|&k| mirror(k) != k && (s(k) - s(mirror(k))).norm() > 0.04 * case.source.diagonal());
    let Some(foot) = sided.min_by(|&a, &b| height(a).total_cmp(&height(b))) else { return vec![] };
    let other = mirror(foot);
    let taken: Vec<SurfacePoint> = good.iter().map(|m| m.1).collect();
    let free = |place: Point3<f64>| {
        let is_free = |v: &u32| !taken.contains(&SurfacePoint::Vertex(*v));
        let distance = |v: &u32| (target.positions[*v as usize] - place).norm();
        let all = (0..target.vertex_count() as u32).filter(is_free);
        SurfacePoint::Vertex(all.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap())
    };
    let mut faults = Vec::new();
    let mut wrong = good.clone();
    wrong[foot].1 = free(t(other));
    faults.push(("marker on the wrong leg", wrong));
    let mut wrong = good.clone();
    (wrong[foot].1, wrong[other].1) = (good[other].1, good[foot].1);
    faults.push(("pair swapped", wrong));
    let mut wrong: Vec<_> = (0..good.len()).map(|k| (good[k].0, good[mirror(k)].1)).collect();
    let mut used: Vec<SurfacePoint> = vec![];
    wrong.retain(|pair| {
        !used.contains(&pair.1) && {
            used.push(pair.1);
            true
        }
    });
    faults.push(("all swapped", wrong));
    let up = Vector3::y() * 0.25 * extent(target);
    let mut wrong = good.clone();
    wrong[foot].1 = free(t(foot) + up);
    wrong[other].1 = free(t(other) + up);
    faults.push(("hooves on knees", wrong));
    faults
}

fn extent(surface: &Surface) -> f64 {
    let y = || surface.positions.iter().map(|p| p.y);
    y().fold(f64::NEG_INFINITY, f64::max) - y().fold(f64::INFINITY, f64::min)
}

/// A spoiled set of results.
pub struct Spoiled {
    pub name: &'static str,
    pub results: Vec<Positions>,
    /// The factor of sources and truths.
    pub scale: f64,
}

/// Results that are wrong, each with the name of its fault. Where sources and truths are scaled as well, nothing is wrong.
pub fn results(case: &Case, target: &Surface, good: &[Positions]) -> Vec<Spoiled> {
    let rest = &case.target.positions;
    let diagonal = case.target.diagonal();
    let components = target.components();
    let count = components.count();
    let of: Vec<Option<u32>> = target.vertex_of.iter().map(|v| components.of_vertex[(*v)? as usize]).collect();
    let mut all = Vec::new();
    let mut add = |name, scale, change: &mut dyn FnMut(usize, &Positions) -> Positions| {
        let results = good.iter().enumerate().map(|(k, pose)| change(k, pose)).collect();
        all.push(Spoiled { name, results, scale });
    };
    let scaled = |by: f64| move |_: usize, pose: &Positions| -> Positions { pose.iter().map(|p| p * by).collect() };
    add("scaled 1.1", 1.0, &mut scaled(1.1));
    add("scaled 1.3", 1.0, &mut scaled(1.3));
    add("scaled 10", 1.0, &mut scaled(10.0));
    add("both scaled 1.3", 1.3, &mut scaled(1.3));
    add("both scaled 10", 10.0, &mut scaled(10.0));
    add("at rest", 1.0, &mut |_, _| rest.clone());
    for (name, amount) in [("noise .05", 0.0005), ("noise .3", 0.003), ("noise 2", 0.02), ("noise 6", 0.06)] {
        add(name, 1.0, &mut |k, pose| {
            let mut random = Random::new(k as u64 + 1);
            let surface = target.from_mesh(pose).unwrap();
            let noisy: Positions = surface.iter().map(|p| p + random.vector() * amount * diagonal).collect();
            target.to_mesh(&noisy).unwrap()
        });
    }
    for (name, amount) in [("vertex off 2", 0.02), ("vertex off 20", 0.20)] {
        add(name, 1.0, &mut |k, pose| {
            let mut random = Random::new(k as u64 + 11);
            let vertex = target.triangles[(random.unit() * target.triangle_count() as f64) as usize][0];
            let mut surface = target.from_mesh(pose).unwrap();
            surface[vertex as usize] += random.vector().normalize() * amount * diagonal;
            target.to_mesh(&surface).unwrap()
        });
    }
    // The part that moves most stays as it is at rest, softly within a ball.
    for (name, radius) in [("part stuck .04", 0.04), ("part stuck .1", 0.1), ("part stuck .2", 0.2)] {
        add(name, 1.0, &mut |k, pose| {
            let truth = case.truth.get(k).unwrap_or(pose);
            let mean = |p: &Positions| p.iter().map(|p| p.coords).sum::<Vector3<f64>>() / p.len() as f64;
            let shift = mean(truth) - mean(rest);
            let moved = |v: usize| (truth[v] - rest[v] - shift).norm();
            let most = (0..rest.len()).filter(|&v| of[v].is_some()).max_by(|&a, &b| moved(a).total_cmp(&moved(b)));
            let centre = rest[most.unwrap()];
            let stuck = |(p, q): (&Point3<f64>, &Point3<f64>)| {
                let x = ((q - centre).norm() / (radius * diagonal)).min(1.0);
                let share = (1.0 - x * x).powi(2);
                p + (q + shift - p) * share
            };
            pose.iter().zip(rest).map(stuck).collect()
        });
    }
    if count > 1 {
        for (name, amount) in [("component off 2", 0.02), ("component off 5", 0.05), ("component off 10", 0.10)] {
            add(name, 1.0, &mut |k, pose| {
                let mut random = Random::new(k as u64 + 21);
                let chosen = Some((random.unit() * count as f64) as u32);
                let by = random.vector().normalize() * amount * diagonal;
                pose.iter().zip(&of).map(|(p, c)| if *c == chosen { p + by } else { *p }).collect()
            });
        }
        add("component left behind", 1.0, &mut |k, pose| {
            let mut random = Random::new(k as u64 + 31);
            let chosen = Some((random.unit() * count as f64) as u32);
            pose.iter().zip(rest).zip(&of).map(|((p, q), c)| if *c == chosen { *q } else { *p }).collect()
        });
        add("half left behind", 1.0, &mut |_, pose| {
            let behind = |c: &Option<u32>| c.is_some_and(|c| c % 2 == 1);
            pose.iter().zip(rest).zip(&of).map(|((p, q), c)| if behind(c) { *q } else { *p }).collect()
        });
    }
    all
}
