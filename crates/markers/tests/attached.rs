//! Files of points on their meshes: units and axes, exchanged files, pairing, and what is wrong with them.

mod common;

use std::path::Path;

use common::{Meshed, NoScenes, both, ellipsoid, pair};
use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostics, Kind};
use mimesh_markers::{
    AttachedMarkers, MarkerFile, MarkerPair, MeshRole, PointSource, export, points_on,
    read::parse_points,
    reattach,
    remedies::{FIT_UNIT_AXES, FORCE_REATTACH, OLD_MESH},
};
use nalgebra::Point3;

type Place = [f64; 3];

/// A line `n5,x,y,z` for each of `vertices` of the ellipsoid, at `change` of its position.
fn rows(vertices: &[usize], change: impl Fn(Place) -> Place) -> String {
    let positions = ellipsoid().0;
    let row = |&v: &usize| {
        let [x, y, z] = change(positions[v].coords.into());
        format!("n{v},{x},{y},{z}\n")
    };
    vertices.iter().map(row).collect()
}

fn same(place: Place) -> Place {
    place
}

fn doubled(place: Place) -> Place {
    place.map(|x| 2.0 * x)
}

fn attach(meshes: &[Meshed; 2], source: &str, target: &str, fit: bool) -> Result<AttachedMarkers, Diagnostics> {
    let files = [("s.csv", source), ("t.csv", target)].map(|(file, text)| parse_points(Path::new(file), text));
    let [source, target] = files;
    PointSource::Sides([source?, target?]).attach(both(meshes), fit)
}

fn vertices(attached: &AttachedMarkers) -> Vec<[u32; 2]> {
    let vertex = |point: MeshPoint| match point {
        MeshPoint::Vertex(v) => v,
        MeshPoint::Triangle(..) => panic!("{point:?} is no vertex"),
    };
    attached.markers.pairs.iter().map(|pair| [pair.source, pair.target.unwrap()].map(vertex)).collect()
}

/// Bent, so that no turn brings the ellipsoid onto itself.
fn bent([x, y, z]: Place) -> Place {
    [x, y + 0.1 * z * z, z + 0.2 * y * y]
}

fn bent_pair() -> [Meshed; 2] {
    let (positions, triangles) = ellipsoid();
    [1.0, 2.0].map(|factor| {
        let positions = positions.iter().map(|p| Point3::from(bent(p.coords.into())) * factor).collect();
        Meshed::new(positions, &triangles)
    })
}

#[test]
fn another_unit_and_other_axes_are_guessed_from_several_points() {
    let meshes = bent_pair();
    let all = [5, 17, 40, 52, 70];
    let target = rows(&all, |at| doubled(bent(at)));
    let centimetres = |at: Place| bent(at).map(|x| 100.0 * x);
    let z_up = |at: Place| {
        let [x, y, z] = bent(at);
        [x, -z, y]
    };
    let both_changed = |at: Place| z_up(at).map(|x| 100.0 * x);
    let changes: [(&dyn Fn(Place) -> Place, &str); 3] = [
        (&centimetres, "times 0.01"),
        (&z_up, "turned from Z up to Y up, (x, y, z) to (x, z, -y)"),
        (&both_changed, "times 0.01 and turned from Z up to Y up, (x, y, z) to (x, z, -y)"),
    ];
    for (change, expected) in changes {
        let source = rows(&all, change);
        let diagnostic = attach(&meshes, &source, &target, false).unwrap_err().list.remove(0);
        let hint = format!("they would fit {expected}: export them in the unit and axes of the mesh");
        assert_eq!(diagnostic.hint, Some(hint));
        assert_eq!(diagnostic.remedy.unwrap().action, FIT_UNIT_AXES);
        let fitted = attach(&meshes, &source, &target, true).unwrap();
        assert_eq!(vertices(&fitted), all.map(|v| [v as u32; 2]));
        assert_eq!(fitted.unit_axes.map(|unit_axes| unit_axes.map(|u| u.to_string())), [Some(expected.into()), None]);
        // Two points fit by chance too easily: nothing is guessed.
        let source = rows(&all[..2], change);
        for fit in [false, true] {
            let diagnostic = attach(&meshes, &source, &target, fit).unwrap_err().list.remove(0);
            assert_eq!(diagnostic.remedy, None);
            assert!(diagnostic.hint.unwrap().ends_with("in its unit and axes?"), "{expected}");
        }
    }
}

#[test]
fn points_of_one_mesh_are_found_alone() {
    let [source, _] = pair();
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("p.csv", rows(&[5, 40, 70], |at| at.map(|x| 100.0 * x))),
        ("m.cons", "3\n5, 9999\n40, 9999\n70, 9999\n".into()),
    ] {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        let points = points_on(&file, source.on(MeshRole::Source), &NoScenes).unwrap();
        let expected = [5, 40, 70].map(|v| source.surface.point(MeshPoint::Vertex(v)).unwrap());
        assert_eq!(points, expected, "{name}");
        assert_eq!(points_on(&file, source.on(MeshRole::Target), &NoScenes).is_ok(), name == "p.csv");
    }
}

#[test]
fn a_point_astray_is_named_with_both_boxes() {
    let failure = attach(&pair(), "a,0,0,3\nb,0,0,-3\nc,9,0,0\n", "a,0,0,6\nb,0,0,-6\nc,0,0,6\n", false).unwrap_err();
    assert_eq!(
        failure.to_string(),
        "error: s.csv:3: point c lies 109 % of the diagonal off the source: expected 5 % at most; the points span x 0 to 9, \
         y 0 to 0, z -3 to 3, the source x -0.966 to 0.966, y -1.93 to 1.93, z -3 to 3\n  hint: pick these points again on \
         the surface, or remove them"
    );
}

#[test]
fn exchanged_files_are_reported() {
    let (source, target) = (rows(&[5, 40, 70], doubled), rows(&[5, 40, 70], same));
    let failure = attach(&pair(), &source, &target, false).unwrap_err();
    assert_eq!(
        failure.to_string(),
        "error: s.csv: the points of s.csv lie on the target, and those of t.csv on the source\n  hint: exchange the two \
         files, or `source` and `target`"
    );
}

#[test]
fn points_are_paired_by_name_or_by_order() {
    let meshes = pair();
    let target = rows(&[70, 5, 40], doubled) + "n7b,0,0,6\n";
    let attached = attach(&meshes, &rows(&[5, 40, 70], same), &target, false).unwrap();
    assert_eq!(vertices(&attached), [[5, 5], [40, 40], [70, 70]]);
    assert_eq!(attached.warnings, ["t.csv: 1 without a partner of that name are left out: n7b"]);

    let by_order = attach(&meshes, "0,0,3\n0,0,-3\n", "a,0,0,-6\nb,0,0,6\n", false).unwrap();
    assert_eq!(vertices(&by_order), [[0, 1], [1, 0]]);
    assert!(by_order.warnings.is_empty());
    let other_names = attach(&meshes, "c,0,0,3\nd,0,0,-3\n", "a,0,0,-6\nb,0,0,6\n", false).unwrap();
    assert_eq!(other_names.warnings, ["s.csv: no name is also in t.csv; the points are paired by order"]);

    let failure = attach(&meshes, "0,0,3\n0,0,-3\n", "a,0,0,-6\n", false).unwrap_err();
    assert_eq!(
        failure.to_string(),
        "error: s.csv: the points cannot be paired: no name is on both sides, and s.csv has 2, t.csv 1\n  hint: call partners \
         alike, or bring as many points in the same order"
    );
    let twice = "<PickedPoints>\n<point x=\"0\" y=\"0\" z=\"3\" name=\"a\"/>\n<point x=\"0\" y=\"0\" z=\"-3\" name=\"a\"/>\n</PickedPoints>";
    let failure = attach(&meshes, twice, "a,0,0,-6\nb,0,0,6\n", false).unwrap_err();
    assert_eq!(
        failure.to_string(),
        "error: s.csv:3: another point is called a (line 2)\n  hint: give each its own name"
    );
}

#[test]
fn points_slightly_off_the_surface_are_a_warning() {
    let attached = attach(&pair(), "a,0,0,3.2\nb,0,0,-3\n", "a,0,0,6\nb,0,0,-6\n", false).unwrap();
    assert_eq!(
        attached.warnings,
        ["1 of 2 points given by position lie more than 1 % of the diagonal off the source, a by 2.7 %"]
    );
}

/// Markers at the two tips of the ellipsoid.
fn tips() -> MarkerFile {
    let tip = |v| MarkerPair::new(MeshPoint::Vertex(v), MeshPoint::Vertex(v));
    MarkerFile { pairs: vec![tip(0), tip(1)], ..MarkerFile::default() }
}

#[test]
fn moved_points_are_doubtful_and_lost_ones_an_error() {
    let meshes = pair();
    let [source, _] = both(&meshes);
    let (mut positions, triangles) = ellipsoid();
    // A tip is cut down by 2 % of the diagonal of about 7.5.
    positions[0].z -= 0.15;
    let cut = Meshed::new(positions.clone(), &triangles);
    let mut markers = tips();
    let moves = reattach(&mut markers, Some(source), cut.on(MeshRole::Source), false).unwrap();
    assert_eq!(moves[0].doubt.as_deref(), Some("moved by 2.1 % of the diagonal"));
    assert_eq!(moves[1].doubt, None);

    let far = Meshed::new(positions.iter().map(|p| p + nalgebra::Vector3::x() * 9.0).collect(), &triangles);
    let diagnostic = reattach(&mut tips(), Some(source), far.on(MeshRole::Source), false).unwrap_err().list.remove(0);
    assert_eq!(diagnostic.remedy.clone().unwrap().action, FORCE_REATTACH);
    assert!(diagnostic.to_string().ends_with("in the same place, or carry them over all the same"), "{diagnostic}");
    assert!(reattach(&mut tips(), Some(source), far.on(MeshRole::Source), true).is_ok());
}

#[test]
fn former_positions_are_needed() {
    let [source, _] = pair();
    let diagnostic = reattach(&mut tips(), None, source.on(MeshRole::Source), false).unwrap_err().list.remove(0);
    let remedy = diagnostic.remedy.clone().unwrap();
    assert_eq!((diagnostic.kind, remedy.action, remedy.argument.as_str()), (Kind::Usage, OLD_MESH, "source"));
    assert_eq!(
        diagnostic.to_string(),
        "the markers do not give the positions that their points of the source had\n  hint: give the source that they were made on"
    );
}

#[test]
fn stale_markers_are_a_warning_only_where_points_have_moved() {
    let meshes = pair();
    let [source, target] = both(&meshes);
    let mut markers = tips();
    markers.record_positions([source, target], [Some(Path::new("a.obj")), None]);
    assert_eq!(markers.source.as_ref().unwrap().vertices, Some(86));
    assert_eq!(markers.stale_warning(Path::new("m.yaml"), source, None), None);
    let (mut positions, triangles) = ellipsoid();
    positions.push(Point3::origin());
    let same_places = Meshed::new(positions.clone(), &triangles);
    assert_eq!(markers.stale_warning(Path::new("m.yaml"), same_places.on(MeshRole::Source), None), None);
    positions[0].z = 2.0;
    let moved = Meshed::new(positions, &triangles);
    assert_eq!(
        markers.stale_warning(Path::new("m.yaml"), moved.on(MeshRole::Source), None).as_deref(),
        Some(
            "m.yaml: made on a source of 86 vertices (a.obj), which now has 87; 1 of 2 points no longer lie where they were \
             put: reattach the markers to carry them over"
        )
    );
}

#[test]
fn names_of_files_fit_their_notation() {
    let meshes = pair();
    let mut markers = tips();
    let error =
        |markers: &MarkerFile, out: &str| export(markers, Path::new(out), both(&meshes)).unwrap_err().to_string();
    assert!(error(&markers, "x.pp").starts_with("error: x.pp: a .pp holds the points of one mesh\n"));
    assert!(error(&markers, "x-{side}.yaml").starts_with("error: x-{side}.yaml: a .yaml holds both sides\n"));
    assert!(error(&markers, "x.xyz").starts_with("error: x.xyz: no notation of markers has this ending\n"));
    markers.pairs[1].source = MeshPoint::Triangle(0, [0.5, 0.5, 0.0]);
    let warnings = export(&markers, Path::new("x.cons"), both(&meshes)).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].starts_with("source: a .cons names vertices only: 1 of 2 points moved"), "{}", warnings[0]);
    markers.pairs[1].target = None;
    assert!(error(&markers, "x.cons").starts_with("error: x.cons: marker 2 has no target yet\n"));
    assert!(export(&markers, Path::new("x.yaml"), both(&meshes)).is_ok());
    markers.pairs[0].source = MeshPoint::Vertex(86);
    assert!(error(&markers, "x.yaml").contains("marker 1: the source has no vertex 86: expected 0 to 85"));
}
