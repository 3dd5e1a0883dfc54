//! What transfers that are made of other transfers promise: `multi_component` with `initial`, `chain` and `blend`.

use mimesh_core::{
    Figures,
    mesh::{Surface, SurfacePoint},
    plugin::stage_of,
    stage::{
        BindInput, BoundTransfer, ComponentRef, Link, Marker, ProximityGraph, Transfer, TransferPair, Transferred,
        TriangleMap,
    },
    testkit::{meshes, random::Random},
};
use mimesh_transfers::{
    blend::{Blend, Part},
    chain::Chain,
    copy_displacement::CopyDisplacement,
    gradient::GradientTransfer,
    multi_component::MultiComponent,
};
use nalgebra::{Point3, Rotation3, Vector3};
use schemars::generate::SchemaSettings;

/// Three bars in a row along x, with gaps of 0.2.
fn row() -> Surface {
    let bar = meshes::bar([4, 2, 2], [1.0, 0.5, 0.5]);
    let n = bar.vertex_count() as u32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..3 {
        let shift = Vector3::new(1.2 * f64::from(k) - 1.2, 0.0, 0.0);
        positions.extend(bar.positions.iter().map(|p| p + shift));
        triangles.extend(bar.triangles.iter().map(|t| t.map(|v| v + k * n)));
    }
    Surface::from_triangles(positions, triangles).unwrap()
}

fn linked(surface: &Surface) -> ProximityGraph {
    let components = surface.components();
    let of = |v: u32| components.of_vertex[v as usize];
    let near = |a: u32, b: u32| (surface.positions[a as usize] - surface.positions[b as usize]).norm() < 0.2001;
    let count = surface.vertex_count() as u32;
    let link = |c: u32| {
        let all = (0..count).flat_map(|a| (0..count).map(move |b| [a, b]));
        let pairs = all.filter(|&[a, b]| of(a) == Some(c) && of(b) == Some(c + 1) && near(a, b)).collect();
        Link { components: [c, c + 1], distance: 0.2, in_tree: true, stiffness: 1.0, pairs }
    };
    let links = vec![link(0), link(1)];
    ProximityGraph::new(components, links, Default::default()).unwrap()
}

fn identity_map(surface: &Surface) -> TriangleMap {
    TriangleMap {
        source_triangle_count: surface.triangle_count(),
        triangles: (0..surface.triangle_count() as u32).map(Some).collect(),
        ..TriangleMap::default()
    }
}

fn run(stage: &dyn Transfer, surface: &Surface, map: &TriangleMap, posed: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let graph = linked(surface);
    let markers: Vec<_> = [0, 20, 50, 90, 120]
        .map(|v| Marker { name: v.to_string(), source: SurfacePoint::Vertex(v), target: SurfacePoint::Vertex(v) })
        .into();
    let pair = TransferPair { source: surface, target: surface, markers: &markers, proximity: Some(&graph) };
    stage.bind(BindInput::new(pair, map)).unwrap().transfer(posed).unwrap().positions
}

fn bent(positions: &[Point3<f64>], angle: f64) -> Vec<Point3<f64>> {
    positions.iter().map(|p| Rotation3::from_axis_angle(&Vector3::z_axis(), angle * p.x) * p).collect()
}

fn largest_distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)
}

fn combined() -> MultiComponent {
    MultiComponent { initial: Some(Box::new(CopyDisplacement::default())), ..MultiComponent::default() }
}

fn of_two(border: f64) -> Blend {
    let part = |transfer: Box<dyn Transfer>, components: Vec<ComponentRef>| Part { transfer, components };
    let first = part(Box::<MultiComponent>::default(), vec![ComponentRef::Number(0)]);
    Blend { parts: vec![first, part(Box::<CopyDisplacement>::default(), vec![])], border }
}

/// Gives the target the source's own vertices.
#[derive(Debug, serde::Deserialize, serde::Serialize)]
struct Mover;

#[typetag::serde(name = "test_mover")]
impl Transfer for Mover {
    fn bind(&self, _: BindInput<'_>) -> mimesh_core::Result<Box<dyn BoundTransfer>> {
        Ok(Box::new(Self))
    }
}

impl BoundTransfer for Mover {
    fn transfer(&self, posed: &[Point3<f64>]) -> mimesh_core::Result<Transferred> {
        Ok(Transferred { positions: posed.to_vec(), ..Transferred::default() })
    }

    fn figures(&self) -> Figures {
        Figures::default()
    }
}

#[test]
fn compositions_keep_rest_and_rigid_motions() {
    let surface = row();
    let chain = Chain { transfers: vec![Box::new(CopyDisplacement::default()), Box::new(MultiComponent::default())] };
    let stages: [(&str, &dyn Transfer); 4] =
        [("initial", &combined()), ("chain", &chain), ("blend", &of_two(0.0)), ("soft blend", &of_two(0.3))];
    for (name, stage) in stages {
        let at_rest = run(stage, &surface, &identity_map(&surface), &surface.positions);
        // Rounding of a factored system of some hundred unknowns.
        assert!(largest_distance(&at_rest, &surface.positions) < 1e-9, "{name}: rest");
        for seed in 0..3 {
            let motion = Random::new(seed).rigid_motion(surface.diagonal());
            let moved: Vec<_> = surface.positions.iter().map(|p| motion * p).collect();
            let found = run(stage, &surface, &identity_map(&surface), &moved);
            assert!(largest_distance(&found, &moved) < 1e-8, "{name}: a rigid motion");
        }
    }
}

#[test]
fn a_component_that_corresponds_to_nothing_goes_where_the_initial_transfer_brings_it() {
    let surface = row();
    let mut map = identity_map(&surface);
    let last = surface.components();
    for (partner, t) in map.triangles.iter_mut().zip(&surface.triangles) {
        *partner = partner.filter(|_| last.of_vertex[t[0] as usize] != Some(2));
    }
    // The source parts the last bar from the others, which gaps of known length do not do.
    let away = |(v, p): (usize, &Point3<f64>)| if last.of_vertex[v] == Some(2) { p + Vector3::x() * 0.5 } else { *p };
    let posed: Vec<_> = surface.positions.iter().enumerate().map(away).collect();
    let gap = |found: &[Point3<f64>]| {
        let ends = linked(&surface).links().nth(1).unwrap().pairs[0];
        (found[ends[0] as usize] - found[ends[1] as usize]).norm()
    };
    let alone = run(&MultiComponent::default(), &surface, &map, &posed);
    assert!((gap(&alone) - 0.2).abs() < 1e-3, "alone it stays: {}", gap(&alone));
    // One that looks at no map.
    let initial = Some(Box::new(Mover) as Box<dyn Transfer>);
    let followed = run(&MultiComponent { initial, ..MultiComponent::default() }, &surface, &map, &posed);
    assert!((gap(&followed) - 0.7).abs() < 1e-6, "it follows: {}", gap(&followed));
}

#[test]
fn the_slot_for_an_initial_transfer_declares_defaults_of_biharmonic() {
    for inline in [false, true] {
        let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = inline);
        let schema = settings.into_generator().into_root_schema_for::<MultiComponent>().to_value();
        let slot = &schema["properties"]["initial"];
        assert_eq!(stage_of(slot), Some("transfer"));
        assert_eq!(slot["x-defaults"]["biharmonic"], serde_json::json!({ "weights": { "type": "biharmonic" } }));
    }
}

#[test]
fn a_chain_of_one_is_that_transfer_and_each_link_takes_what_the_one_before_made() {
    let surface = row();
    let (map, posed) = (identity_map(&surface), bent(&surface.positions, 0.4));
    let alone = run(&MultiComponent::default(), &surface, &map, &posed);
    let one = Chain { transfers: vec![Box::new(MultiComponent::default())] };
    assert_eq!(run(&one, &surface, &map, &posed), alone);
    let stiff = || MultiComponent { rigid: vec![ComponentRef::Name("all".into())], ..MultiComponent::default() };
    let two = Chain { transfers: vec![Box::new(CopyDisplacement::default()), Box::new(stiff())] };
    let found = run(&two, &surface, &map, &posed);
    let edges = surface.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let length = |of: &[Point3<f64>], [a, b]: [u32; 2]| (of[a as usize] - of[b as usize]).norm();
    let stretch = edges.map(|e| (length(&found, e) - length(&surface.positions, e)).abs()).fold(0.0, f64::max);
    // Positions of rigid components are rest turned and moved.
    assert!(stretch < 1e-12, "bars stay as they are: {stretch}");
}

#[test]
fn each_part_of_a_blend_with_a_hard_border_is_its_own_transfer() {
    let surface = row();
    let (map, posed) = (identity_map(&surface), bent(&surface.positions, 0.4));
    let found = run(&of_two(0.0), &surface, &map, &posed);
    let parts = [
        run(&MultiComponent::default(), &surface, &map, &posed),
        run(&CopyDisplacement::default(), &surface, &map, &posed),
    ];
    for (v, c) in surface.components().of_vertex.iter().enumerate() {
        assert_eq!(found[v], parts[usize::from(*c != Some(0))][v], "vertex {v}");
    }
    // One transfer for all parts is that transfer, whatever the border; gradients are integrated within rounding.
    let same = |components: Vec<ComponentRef>| Part { transfer: Box::new(MultiComponent::default()), components };
    let blend = Blend { parts: vec![same(vec![ComponentRef::Number(1)]), same(vec![])], border: 0.3 };
    assert!(largest_distance(&run(&blend, &surface, &map, &posed), &parts[0]) < 1e-9);
}

#[test]
fn parts_that_overlap_or_leave_something_out_are_named() {
    let surface = row();
    let part = |components: Vec<ComponentRef>| Part { transfer: Box::new(GradientTransfer::default()), components };
    let refused = |parts: Vec<Part>| {
        let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: None };
        Blend { parts, border: 0.0 }.check(pair).unwrap_err().to_string()
    };
    let number = |k: u32| vec![ComponentRef::Number(k)];
    assert!(refused(vec![part(number(0)), part(number(0)), part(vec![])]).contains("parts[0] and to parts[1]"));
    assert!(refused(vec![part(number(0))]).contains("belong to no part"));
    assert!(refused(vec![part(vec![]), part(vec![])]).contains("two parts name no components"));
    assert!(refused(vec![part(number(7)), part(vec![])]).contains("parts[0]: the target has no component number 7"));
    assert!(
        Chain { transfers: vec![] }
            .check(TransferPair { source: &surface, target: &surface, markers: &[], proximity: None })
            .unwrap_err()
            .to_string()
            .contains("one transfer or more")
    );
}

#[test]
fn several_poses_at_once_have_the_results_that_each_has_alone() {
    let surface = row();
    let mut map = identity_map(&surface);
    // The last bar is an orphan, so that poses take different numbers of steps.
    for (partner, t) in map.triangles.iter_mut().zip(&surface.triangles) {
        *partner = partner.filter(|_| surface.components().of_vertex[t[0] as usize] != Some(2));
    }
    let graph = linked(&surface);
    let markers: Vec<_> = [0, 20, 50, 90, 120]
        .map(|v| Marker { name: v.to_string(), source: SurfacePoint::Vertex(v), target: SurfacePoint::Vertex(v) })
        .into();
    let pair = TransferPair { source: &surface, target: &surface, markers: &markers, proximity: Some(&graph) };
    let chain = Chain { transfers: vec![Box::new(CopyDisplacement::default()), Box::new(combined())] };
    let stages: [(&str, &dyn Transfer); 5] = [
        ("multi_component", &MultiComponent::default()),
        ("initial", &combined()),
        ("chain", &chain),
        ("blend", &of_two(0.0)),
        ("soft blend", &of_two(0.3)),
    ];
    for (name, stage) in stages {
        let bound = stage.bind(BindInput::new(pair, &map)).unwrap();
        // More than are solved for together, among them one that is refused.
        let mut poses: Vec<_> = (0..11).map(|k| bent(&surface.positions, 0.1 * f64::from(k))).collect();
        poses[4][7].x = f64::NAN;
        let poses: Vec<&[Point3<f64>]> = poses.iter().map(Vec::as_slice).collect();
        let together = bound.transfer_all(&poses);
        assert_eq!(together.len(), poses.len(), "{name}");
        for (k, (posed, result)) in poses.iter().zip(together).enumerate() {
            match (bound.transfer(posed), result) {
                (Ok(alone), Ok(result)) => {
                    assert!(alone.positions == result.positions, "{name}: pose {k} differs among others");
                    assert_eq!(alone.figures, result.figures, "{name}: pose {k}");
                }
                (alone, result) => assert!(k == 4 && alone.is_err() && result.is_err(), "{name}: pose {k}"),
            }
        }
    }
}
