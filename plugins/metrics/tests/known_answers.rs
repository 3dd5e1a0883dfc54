//! Limits against real meshes: known results are not bad, and spoiled ones are told from them.
//!
//! `tests/verdicts` of the program judges whole sets of results, good and spoiled.

use std::path::{Path, PathBuf};

use mimesh_core::{
    mesh::{Mesh, Surface, SurfacePoint},
    plugin,
    stage::{Limits, Marker, Metric, MetricContext, MetricInput, Posed, Statistic, TransferPair},
    testkit::{
        data::{data, read_mesh},
        random::Random,
    },
};
use mimesh_formats as _;
use mimesh_metrics as _;
use nalgebra::{Point3, Vector3};

/// A source and a target at rest, with markers as pairs of vertices.
struct Scene {
    source: Surface,
    mesh: Mesh,
    target: Surface,
    markers: Vec<[u32; 2]>,
    data: PathBuf,
}

impl Scene {
    /// `None` where the data is missing.
    fn new(source: &str, target: &str) -> Option<Self> {
        let data = data("")?;
        let mesh = read(&data.join(target));
        let (source, target) = (Surface::new(&read(&data.join(source))).unwrap(), Surface::new(&mesh).unwrap());
        Some(Self { source, mesh, target, markers: vec![], data })
    }

    fn animals() -> Option<Self> {
        let mut scene = Self::new("sumner-horse-poses/horse-reference.obj", "sumner-camel-poses/camel-reference.obj")?;
        let text = std::fs::read_to_string(scene.data.join("markers/horse_camel.cons")).unwrap();
        let number = |text: &str| text.trim().parse::<u32>().unwrap();
        let pair = |line: &str| line.split_once(',').map(|(s, t)| [number(s), number(t)]);
        scene.markers = text.lines().filter_map(pair).collect();
        assert_eq!(scene.markers.len(), 107);
        Some(scene)
    }

    /// Statistics above their bad limits as `metric.statistic`, with the source and the target in a pose each.
    fn bad(&self, source: &[Point3<f64>], result: &[Point3<f64>]) -> Vec<String> {
        self.above(source, result, |limits| limits.bad)
    }

    /// The same for the limits above which a statistic is doubtful.
    fn doubtful(&self, source: &[Point3<f64>], result: &[Point3<f64>]) -> Vec<String> {
        self.above(source, result, |limits| limits.doubtful)
    }

    fn above(&self, source: &[Point3<f64>], result: &[Point3<f64>], limit: fn(&Limits) -> f64) -> Vec<String> {
        let marker = |&[s, t]: &[u32; 2]| Marker {
            name: s.to_string(),
            source: SurfacePoint::Vertex(self.source.vertex_of[s as usize].unwrap()),
            target: SurfacePoint::Vertex(self.target.vertex_of[t as usize].unwrap()),
        };
        let markers: Vec<_> = self.markers.iter().map(marker).collect();
        let pair = TransferPair { source: &self.source, target: &self.target, markers: &markers, proximity: None };
        let context = MetricContext { pair: Some(pair), ..MetricContext::alone(&self.mesh, &self.target) };
        let mut found_above = Vec::new();
        for (name, metric) in plugin::instances::<dyn Metric>() {
            let posed = Posed { mesh: result, surface: &self.target.from_mesh(result).unwrap() };
            let input = MetricInput { source: Some(source), ..MetricInput::alone(posed) };
            let found = metric.bind(context).unwrap().measure(input).unwrap().statistics;
            let declared = metric.statistics();
            let is_above = |statistic: &&Statistic| {
                let value = found.number(statistic.name).map(f64::abs);
                statistic.limits.zip(value).is_some_and(|(limits, value)| value > limit(&limits))
            };
            found_above.extend(declared.iter().filter(is_above).map(|statistic| format!("{name}.{}", statistic.name)));
        }
        found_above
    }

    fn source_pose(&self, file: &str) -> Vec<Point3<f64>> {
        self.source.from_mesh(&read(&self.data.join(file)).positions).unwrap()
    }

    fn pose(&self, file: &str) -> Vec<Point3<f64>> {
        read(&self.data.join(file)).positions
    }
}

fn read(file: &Path) -> Mesh {
    read_mesh(file).rest
}

#[test]
fn known_results_are_not_bad() {
    let none = Vec::<String>::new();
    let Some(animals) = Scene::animals() else { return };
    for pose in ["01", "03", "08"] {
        let source = animals.source_pose(&format!("sumner-horse-poses/horse-{pose}.obj"));
        assert_eq!(animals.bad(&source, &animals.pose(&format!("sumner-camel-poses/camel-{pose}.obj"))), none);
    }
    let cats = Scene::new("sumner-cat-poses/cat-reference.obj", "sumner-lion-poses/lion-reference.obj").unwrap();
    for pose in ["02", "04", "07"] {
        let source = cats.source_pose(&format!("sumner-cat-poses/cat-{pose}.obj"));
        assert_eq!(cats.bad(&source, &cats.pose(&format!("sumner-lion-poses/lion-{pose}.obj"))), none);
    }
    for target in ["target-child", "plates-heavy"] {
        let bodies = Scene::new("bodies/source/rest.obj", &format!("bodies/{target}/rest.obj")).unwrap();
        for pose in ["crouch", "reach"] {
            let source = bodies.source_pose(&format!("bodies/source/{pose}.obj"));
            assert_eq!(bodies.bad(&source, &bodies.pose(&format!("bodies/{target}/truth-{pose}.ply"))), none);
        }
    }
}

#[test]
fn a_marker_on_the_wrong_leg_is_doubtful_and_swapped_sides_are_bad() {
    let Some(mut animals) = Scene::animals() else { return };
    let given = animals.markers.clone();
    let rest = (animals.source.positions.clone(), animals.mesh.positions.clone());
    // Across the animal x runs; a marker's mirror is the one nearest to where it would be on the other side.
    let at = |&[s, _]: &[u32; 2]| rest.0[s as usize];
    let mirror = |pair: &[u32; 2]| {
        let p = at(pair);
        let there = Point3::new(-p.x, p.y, p.z);
        let distance = |other: &&[u32; 2]| (at(other) - there).norm();
        *given.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    let lowest = |pair: &&[u32; 2]| at(pair).y + if mirror(pair) == **pair { 1.0 } else { 0.0 };
    let foot = *given.iter().min_by(|a, b| lowest(a).total_cmp(&lowest(b))).unwrap();
    let beside = rest.1[mirror(&foot)[1] as usize];
    let free = |v: &u32| given.iter().all(|[_, t]| t != v);
    let distance = |v: &u32| (rest.1[*v as usize] - beside).norm();
    let wrong = (0..rest.1.len() as u32).filter(free).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
    animals.markers.iter_mut().filter(|pair| **pair == foot).for_each(|pair| pair[1] = wrong);
    assert_eq!(animals.doubtful(&rest.0, &rest.1), ["marker_fit.outlier"]);

    animals.markers = given.iter().map(|pair| [pair[0], mirror(pair)[1]]).collect();
    // Two that mirror to the same one would share a point.
    animals.markers.sort_by_key(|pair| pair[1]);
    animals.markers.dedup_by_key(|pair| pair[1]);
    assert_eq!(animals.bad(&rest.0, &rest.1), ["marker_fit.mirrored"]);
}

#[test]
fn a_wrong_scale_noise_and_a_loose_component_are_bad() {
    let Some(plates) = Scene::new("bodies/source/rest.obj", "bodies/plates-child/rest.obj") else { return };
    let source = plates.source_pose("bodies/source/kick.obj");
    let truth = plates.pose("bodies/plates-child/truth-kick.ply");
    let large: Vec<_> = truth.iter().map(|p| p * 10.0).collect();
    let bad = plates.bad(&source, &large);
    assert!(bad.contains(&"edge_stretch.median_beyond".into()) && bad.contains(&"volume.beyond".into()), "{bad:?}");
    // The source comes in the same unit: nothing is wrong with the transfer, but the units deserve a look.
    let source_large: Vec<_> = source.iter().map(|p| p * 10.0).collect();
    assert_eq!(plates.bad(&source_large, &large), Vec::<String>::new());
    assert!(plates.doubtful(&source_large, &large).contains(&"edge_stretch.median".into()));

    let mut random = Random::new(1);
    let amount = 0.003 * plates.target.diagonal();
    let noisy: Vec<_> = truth.iter().map(|p| p + random.vector() * amount).collect();
    // Ugly, but each vertex is where it should be to 0.5 %.
    assert_eq!(plates.bad(&source, &noisy), Vec::<String>::new());
    let doubtful = plates.doubtful(&source, &noisy);
    for statistic in ["edge_stretch.beyond", "flipped_triangles.beyond_share", "self_intersections.beyond_share"] {
        assert!(doubtful.iter().any(|found| found == statistic), "{statistic} in {doubtful:?}");
    }
    let amount = 0.06 * plates.target.diagonal();
    let wild: Vec<_> = truth.iter().map(|p| p + random.vector() * amount).collect();
    assert!(plates.bad(&source, &wild).contains(&"edge_stretch.beyond".into()));

    let components = plates.target.components();
    let loose = |v: usize| components.of_vertex[plates.target.vertex_of[v].unwrap() as usize] == Some(87);
    let step = Vector3::x() * 0.1 * plates.target.diagonal();
    let moved = truth.iter().enumerate().map(|(v, p)| if loose(v) { p + step } else { *p });
    assert!(plates.bad(&source, &moved.collect::<Vec<_>>()).contains(&"component_gaps.worst_component".into()));
}

#[test]
fn a_single_vertex_far_off_and_a_target_at_rest_are_not_good() {
    let Some(animals) = Scene::animals() else { return };
    let source = animals.source_pose("sumner-horse-poses/horse-03.obj");
    let mut spoiled = animals.pose("sumner-camel-poses/camel-03.obj");
    spoiled[9000] += Vector3::y() * 0.2 * animals.target.diagonal();
    assert!(animals.doubtful(&source, &spoiled).contains(&"edge_stretch.tear".into()));
    assert!(animals.doubtful(&source, &animals.mesh.positions).contains(&"source_motion.lag".into()));
    assert!(animals.bad(&source, &animals.mesh.positions).contains(&"source_motion.mean".into()));
}

#[test]
fn a_vertex_that_no_triangle_uses_changes_no_limit() {
    let Some(mut animals) = Scene::animals() else { return };
    let source = animals.source_pose("sumner-horse-poses/horse-01.obj");
    let mut result = animals.pose("sumner-camel-poses/camel-01.obj");
    let expected = animals.doubtful(&source, &result);
    let far = Point3::new(1.0, 2.0, 3.0) * 10.0 * animals.target.diagonal();
    animals.mesh.positions.push(far);
    animals.target = Surface::new(&animals.mesh).unwrap();
    result.push(far + Vector3::x());
    assert_eq!(animals.doubtful(&source, &result), expected);
}
