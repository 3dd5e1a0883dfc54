//! Files of points on their meshes: units and axes, exchanged files, pairing, and what is wrong with them.

mod common;

use std::path::Path;

use common::{Meshed, NoScenes, both, ellipsoid, pair};
use mimesh_core::{mesh::MeshPoint, stage::ScenePoint};
use mimesh_document::{Diagnostics, Kind};
use mimesh_markers::{
    AttachedMarkers, MarkerFile, MarkerFiles, MarkerPair, MeshRole, PointSource, ScenePoints, export, points_on,
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
    attached.markers.pairs.iter().map(|pair| [pair.source.unwrap(), pair.target.unwrap()].map(vertex)).collect()
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
fn a_stray_is_named_and_does_not_hide_what_the_others_say() {
    let meshes = bent_pair();
    let all = [5, 17, 40, 52, 70];
    let target = rows(&all, |at| doubled(bent(at)));
    let z_up = |at: Place| {
        let [x, y, z] = bent(at);
        [100.0 * x, -100.0 * z, 100.0 * y]
    };
    // Far away, and so near that it stretches nothing.
    for stray in ["stray,9e6,0,0\n", "stray,0,0,0\n"] {
        let source = rows(&all, z_up) + stray;
        let target = target.clone() + "stray,0,0,6\n";
        let diagnostic = attach(&meshes, &source, &target, false).unwrap_err().list.remove(0);
        let expected = "all but stray would fit times 0.01 and turned from Z up to Y up, (x, y, z) to (x, z, -y): export them in \
                        the unit and axes of the mesh; pick that point again on the surface, or remove it";
        assert_eq!(diagnostic.hint.as_deref(), Some(expected));
        // Fitted, the stray alone is left.
        let diagnostic = attach(&meshes, &source, &target, true).unwrap_err().list.remove(0);
        assert!(diagnostic.message.starts_with("point stray lies"), "{}", diagnostic.message);
        assert_eq!(diagnostic.hint.as_deref(), Some("pick these points again on the surface, or remove them"));
    }
    // Points where they belong do not fit anything else because one is astray.
    let diagnostic = attach(&meshes, &(rows(&all, bent) + "stray,9,0,0\n"), &target, false).unwrap_err().list.remove(0);
    assert_eq!(diagnostic.remedy, None);
    assert!(diagnostic.message.starts_with("point stray lies"), "{}", diagnostic.message);
    // A vertex that is missing does not hide it either.
    let source = format!("name,x,y,z,vertex\n{}wrong,,,,9999\n", rows(&all, z_up).replace('\n', ",\n"));
    if let Ok(file) = parse_points(Path::new("s.csv"), &source) {
        let files = [file, parse_points(Path::new("t.csv"), &target).unwrap()];
        let text = PointSource::Sides(files).attach(both(&meshes), false).unwrap_err().to_string();
        assert!(text.contains("no vertex 9999") && text.contains("would fit times 0.01"), "{text}");
    }
}

/// Points of 3D Slicer in `system` for `vertices`, at `change` of their positions.
fn fcsv(system: &str, vertices: &[usize], change: impl Fn(Place) -> Place) -> String {
    let lines = rows(vertices, change);
    let lines = lines.lines().map(|line| {
        let (name, place) = line.split_once(',').unwrap();
        format!("1,{place},0,0,0,1,1,1,0,{name},,\n")
    });
    format!("# CoordinateSystem = {system}\n{}", lines.collect::<String>())
}

fn half_turn([x, y, z]: Place) -> Place {
    [-x, -y, z]
}

#[test]
fn points_of_slicer_are_taken_to_the_system_of_the_mesh() {
    let meshes = bent_pair();
    let all = [5, 17, 40, 52, 70];
    let attach = |source: &str, target: &str, fit: bool| {
        let files = [("s.fcsv", source), ("t.fcsv", target)];
        let [source, target] = files.map(|(file, text)| parse_points(Path::new(file), text).unwrap());
        PointSource::Sides([source, target]).attach(both(&meshes), fit)
    };
    // The mesh is in RAS, as one of the files; the other says LPS and is turned.
    let target = fcsv("RAS", &all, |at| doubled(bent(at)));
    let attached = attach(&fcsv("LPS", &all, |at| half_turn(bent(at))), &target, false).unwrap();
    assert_eq!(vertices(&attached), all.map(|v| [v as u32; 2]));
    let notes: Vec<_> = attached.notes.iter().map(|note| (note.about, note.chosen.as_str())).collect();
    assert_eq!(notes, [("source", "LPS turned to RAS, (x, y, z) to (-x, -y, z)"), ("target", "RAS")]);
    assert!(attached.warnings.is_empty(), "{:?}", attached.warnings);
    // One stray does not change that, and is named.
    let stray = fcsv("LPS", &all, |at| half_turn(bent(at))) + "1,9,9,9,0,0,0,1,1,1,0,stray,,\n";
    let diagnostic = attach(&stray, &target, false).unwrap_err().list.remove(0);
    assert!(diagnostic.message.starts_with("point stray lies"), "{}", diagnostic.message);
    assert_eq!(diagnostic.hint.as_deref(), Some("pick these points again on the surface, or remove them"));
    // Millimetres beside metres are found as well.
    let millimetres = fcsv("LPS", &all, |at| half_turn(bent(at)).map(|x| 1000.0 * x));
    let hint = attach(&millimetres, &target, false).unwrap_err().list.remove(0).hint.unwrap();
    assert!(hint.starts_with("they would fit times 0.001 and turned between LPS and RAS"), "{hint}");
    assert_eq!(vertices(&attach(&millimetres, &target, true).unwrap()), all.map(|v| [v as u32; 2]));
}

#[test]
fn points_that_lie_on_the_mesh_in_both_systems_are_told() {
    // The ellipsoid is its own image under the half turn.
    let source = parse_points(Path::new("s.fcsv"), &fcsv("LPS", &[5, 40, 70], same)).unwrap();
    let target = parse_points(Path::new("t.csv"), &rows(&[5, 40, 70], doubled)).unwrap();
    let attached = PointSource::Sides([source, target]).attach(both(&pair()), false).unwrap();
    assert_eq!(vertices(&attached), [[5, 5], [40, 40], [70, 70]]);
    let [warning] = &attached.warnings[..] else { panic!("{:?}", attached.warnings) };
    assert!(
        warning
            .starts_with("s.fcsv: its points lie on the source alike in LPS, as the file has them, and turned to RAS")
    );
    // At the tips the two are one point, so there is nothing to tell.
    let [source, target] = [("s.fcsv", same as fn(Place) -> Place), ("t.fcsv", doubled)]
        .map(|(file, change)| parse_points(Path::new(file), &fcsv("RAS", &[0, 1], change)).unwrap());
    let attached = PointSource::Sides([source, target]).attach(both(&pair()), false).unwrap();
    assert!(attached.warnings.is_empty(), "{:?}", attached.warnings);
}

/// A scene with the nodes of each file.
struct Nodes(Vec<(&'static str, Vec<ScenePoint>)>);

impl ScenePoints for Nodes {
    fn scene_points(&self, file: &Path) -> Option<mimesh_core::Result<Vec<ScenePoint>>> {
        self.0.iter().find(|(name, _)| Path::new(name) == file).map(|(_, nodes)| Ok(nodes.clone()))
    }
}

fn node(name: &str, [x, y, z]: Place) -> ScenePoint {
    ScenePoint { name: name.into(), position: Point3::new(x, y, z), is_doubtful: name.starts_with("group") }
}

#[test]
fn nodes_of_scenes_are_paired_by_the_names_of_both_sides() {
    let [top, low] = [[0.0, 0.0, 3.0], [0.0, 0.0, -3.0]];
    let source = vec![node("group", [0.0; 3]), node("low", low), node("own", [9.0; 3]), node("top", top)];
    let mut target = vec![node("top", doubled(top)), node("group", [0.0; 3]), node("low", doubled(low))];
    let files = MarkerFiles::Pair { source: "a.glb".into(), target: "b.glb".into() };
    let read = |source: &[ScenePoint], target: &[ScenePoint]| {
        let nodes = Nodes(vec![("a.glb", source.to_vec()), ("b.glb", target.to_vec())]);
        PointSource::read(&files, &nodes).and_then(|points| points.attach(both(&pair()), false))
    };
    let attached = read(&source, &target).unwrap();
    assert_eq!(vertices(&attached), [[1, 1], [0, 0]]);
    let told = ["a.glb", "b.glb"]
        .map(|file| format!("{file}: 1 groups and ends of joints off the surface and left out: group"));
    assert_eq!(attached.warnings, told);
    // A node that stands for nothing else has to lie on the mesh.
    target.push(node("own", [9.0; 3]));
    assert!(read(&source, &target).unwrap_err().to_string().contains("point own lies"));
    let error = read(&source, &[node("Top", top)]).unwrap_err().to_string();
    assert!(error.contains("no name is on both sides; a.glb has group, low, own, top, b.glb has Top"), "{error}");
    assert!(read(&source, &[]).unwrap_err().to_string().contains("no points: the scene has no named node"));
    let nodes = Nodes(vec![("a.glb", source)]);
    let one = PointSource::read(&MarkerFiles::One("a.glb".into()), &nodes).unwrap_err().to_string();
    assert!(one.contains("a .glb holds the points of one mesh only"), "{one}");
}

#[test]
fn two_sets_of_landmarks_in_one_file_are_source_and_target() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("m.landmarkAscii");
    let sets = "Markers { float[3] Coordinates } @1\nMarkers { float[3] Coordinates2 } @2\n";
    let text = format!("# Avizo 3D ASCII 2.0\ndefine Markers 2\n{sets}\n@1\n0 0 3\n0 0 -3\n\n@2\n0 0 6\n0 0 -6\n");
    std::fs::write(&file, &text).unwrap();
    let both_sides = MarkerFiles::One(file.clone());
    let attached = PointSource::read(&both_sides, &NoScenes).unwrap().attach(both(&pair()), false).unwrap();
    assert_eq!(vertices(&attached), [[0, 0], [1, 1]]);
    assert!(attached.warnings.is_empty() && attached.notes.is_empty());
    let [_, target] = pair();
    assert_eq!(points_on(&file, target.on(MeshRole::Target), &NoScenes).unwrap().len(), 2);
    let twice = MarkerFiles::Pair { source: file.clone(), target: file.clone() };
    assert!(PointSource::read(&twice, &NoScenes).unwrap_err().to_string().contains("holds both sides"));
    std::fs::write(&file, text.replace("Markers { float[3] Coordinates2 } @2\n", "")).unwrap();
    assert!(PointSource::read(&both_sides, &NoScenes).unwrap_err().to_string().contains("one set of landmarks"));
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
    assert_eq!((by_order.notes[0].about, by_order.notes[0].chosen.as_str()), ("pairs", "by order"));
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
    markers.pairs[1].source = Some(MeshPoint::Triangle(0, [0.5, 0.5, 0.0]));
    let warnings = export(&markers, Path::new("x.cons"), both(&meshes)).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].starts_with("source: a .cons names vertices only: 1 of 2 points moved"), "{}", warnings[0]);
    markers.pairs[1].target = None;
    assert!(error(&markers, "x.cons").starts_with("error: x.cons: marker 2 has no target yet\n"));
    assert!(export(&markers, Path::new("x.yaml"), both(&meshes)).is_ok());
    markers.pairs[0].source = Some(MeshPoint::Vertex(86));
    assert!(error(&markers, "x.yaml").contains("marker 1: the source has no vertex 86: expected 0 to 85"));
}
