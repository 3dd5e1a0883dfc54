//! Markers from and to other programs, as a user converts them.

mod common;

use std::path::Path;

use common::{
    Project,
    ellipsoid::{MESHES, ellipsoid, markers, obj, position, project, scaled},
};
use mimesh::{
    core::{
        mesh::{Mesh, MeshPoint, Surface},
        testkit::data::data,
    },
    markers::{MarkerFile, MarkerMesh, MeshRole, formats::cons, read_markers},
};
use nalgebra::Point3;

/// The vertices of a `.cons` that `files` become.
fn converted(project: &Project, files: &[&str]) -> String {
    let output = markers(project, "convert", &[files, &["out.cons"]].concat(), &[&MESHES[..], &["--force"]].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    project.read("out.cons")
}

#[test]
fn every_notation_leads_to_the_same_vertices() {
    let project = project("m.cons");
    let (triangles, vertices) = (ellipsoid(8, 12).1, [5_u32, 40, 70]);
    let corner = |vertex: u32| {
        let t = triangles.iter().position(|t| t.contains(&vertex)).expect("a triangle");
        let k = triangles[t].iter().position(|v| *v == vertex).expect("a corner");
        (t, [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]][k])
    };
    for (side, factor) in [("s", 1.0), ("t", 2.0)] {
        let named = |format: &dyn Fn(usize, [f64; 3]) -> String| -> Vec<String> {
            vertices.iter().enumerate().map(|(i, v)| format(i, position(*v as usize, factor))).collect()
        };
        let pp = named(&|i, [x, y, z]| format!(" <point z=\"{z}\" name=\"n{i}\" x=\"{x}\" active=\"1\" y=\"{y}\"/>\n"));
        let inactive = " <point x=\"99\" y=\"99\" z=\"99\" name=\"gone\" active=\"0\"/>\n";
        project.write(&format!("{side}.pp"), &format!("<PickedPoints>\n{}{inactive}</PickedPoints>\n", pp.concat()));
        let csv = named(&|i, [x, y, z]| format!("n{i};{x};{y};{z}\r\n"));
        project.write(&format!("{side}.csv"), &format!("\u{feff}name;x;y;z\r\n{}", csv.concat()));
        let empties = named(&|i, at| format!("\"n{i}\": {at:?}"));
        project.write(&format!("{side}-empties.json"), &format!("{{{}}}", empties.join(",\n")));
        let listed = named(&|i, at| format!("{{\"position\": {at:?}, \"name\": \"n{i}\"}}"));
        project.write(&format!("{side}-list.json"), &format!("[{}]", listed.join(",\n")));
        let groups: Vec<_> = vertices.iter().enumerate().map(|(i, v)| format!("\"n{i}\": {v}")).collect();
        project.write(&format!("{side}-groups.json"), &format!("{{{}}}", groups.join(", ")));
        let wrap: Vec<_> = vertices
            .iter()
            .map(|v| {
                let (t, [a, b]) = corner(*v);
                format!("[{t}, {a:?}, {b:?}]")
            })
            .collect();
        project.write(&format!("{side}-wrap.txt"), &format!("[{}]", wrap.join(", ")));
    }
    let expected = "3\n5, 5\n40, 40\n70, 70\n";
    let notations = [".pp", ".csv", "-empties.json", "-list.json", "-groups.json", "-wrap.txt"];
    for notation in notations {
        let files = [format!("s{notation}"), format!("t{notation}")];
        assert_eq!(converted(&project, &[&files[0], &files[1]]), expected, "{notation}");
    }
    // Sides may come from different programs.
    assert_eq!(converted(&project, &["s.pp", "t-groups.json"]), expected);
    let output = markers(&project, "convert", &["s.pp", "t.csv", "x.yaml"], &MESHES);
    assert!(output.stderr.contains("warning: s.pp: 1 not active and left out: gone"), "{}", output.stderr);
    assert!(
        output.stdout.contains("source: 3 by position; off the surface by 0.000 % of the diagonal"),
        "{}",
        output.stdout
    );
}

#[test]
fn what_is_written_is_read_again() {
    let project = project("m.yaml");
    project.write(
        "m.yaml",
        "markers:\n  - { name: \"left ear, tip\", source: 5, target: 6 }\n  \
         - { name: nose, source: { triangle: 20, barycentric: [0.25, 0.5, 0.25] }, target: 41 }\n  - { source: 70, target: { triangle: 30, barycentric: [0.5, 0.25, 0.25] } }\n",
    );
    let output = markers(&project, "convert", &["m.yaml", "first.yaml"], &MESHES);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let points = |file: &str| -> Vec<(MeshPoint, Option<MeshPoint>)> {
        let file = read_markers(&project.path(file)).expect("markers");
        file.pairs.iter().map(|entry| (entry.source.expect("a point of the source"), entry.target)).collect()
    };
    let expected = points("m.yaml");
    assert_eq!(points("first.yaml"), expected);
    for ending in ["pp", "csv", "json", "txt"] {
        let out = format!("points-{{side}}.{ending}");
        let output = markers(&project, "convert", &["m.yaml", &out], &MESHES);
        assert_eq!(output.status, 0, "{}", output.stderr);
        let back = format!("{ending}.yaml");
        let files = ["source", "target"].map(|side| format!("points-{side}.{ending}"));
        let output = markers(&project, "convert", &[&files[0], &files[1], &back], &MESHES);
        assert_eq!(output.status, 0, "{ending}: {}", output.stderr);
        let (source, target) = (scaled(1.0), scaled(2.0));
        let place = |(mesh, surface): &(Mesh, Surface), point: MeshPoint| {
            MarkerMesh { role: MeshRole::Source, mesh, surface }.position(point).expect("a point of the mesh")
        };
        for ((s, t), (expected_s, expected_t)) in points(&back).into_iter().zip(&expected) {
            let off = (place(&source, s) - place(&source, *expected_s)).norm()
                + (place(&target, t.expect("a target")) - place(&target, expected_t.expect("a target"))).norm();
            // A few roundings of coordinates of size 6.
            assert!(off < 1e-12, "{ending}: {off}");
        }
    }
}

#[test]
fn a_pipeline_names_a_file_for_each_side() {
    let project = project("{ source: s.csv, target: t.csv }");
    let rows = |factor: f64, order: [usize; 3]| -> String {
        let row = |v: usize| {
            let [x, y, z] = position(v, factor);
            format!("n{v},{x},{y},{z}\n")
        };
        order.map(row).concat()
    };
    project.write("s.csv", &rows(1.0, [5, 40, 70]));
    project.write("t.csv", &(rows(2.0, [70, 5, 40]) + "n7b,0,0,6\n"));
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(output.stderr, "warning: t.csv: 1 without a partner of that name are left out: n7b\n");
    let output = markers(&project, "convert", &["named.cons"], &["--pipeline", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(project.read("named.cons"), "3\n5, 5\n40, 40\n70, 70\n");
    for (from, to, expected) in [
        ("target: t.csv }", "taget: t.csv }", "error: p.yaml:3:27: unknown key `taget`"),
        (", target: t.csv }", "}", "error: p.yaml:3:10: missing key `target`"),
        ("target: t.csv }", "target: 3 }", "error: p.yaml:3:35: `target`: expected a string, found 3"),
        ("target: t.csv }", "target: u.csv }", "error: p.yaml:3:35: no such file: u.csv"),
        ("{ source: s.csv, target: t.csv }", "[a, b]", "error: p.yaml:3:10: `markers`: expected a path, or a mapping"),
        ("{ source: s.csv, target: t.csv }", "s.csv", "error: s.csv: a .csv holds the points of one mesh only"),
    ] {
        let text = project.read("p.yaml");
        project.edit(from, to);
        let output = project.mimesh(&["check", "p.yaml"]);
        assert!(output.stderr.contains(expected), "{expected}\n{}", output.stderr);
        project.write("p.yaml", &text);
    }
}

#[test]
fn meshes_of_a_pipeline_are_read_whatever_its_other_slots_say() {
    let project = project("m.cons");
    project.write("m.cons", "1\n5, 5\n");
    let whole = project.read("p.yaml");
    project.write("p.yaml", &format!("{whole}matrix: {{ variables.t: [0.1, 0.2] }}\ngates: {{ volume: ${{t}} }}\n"));
    let output = markers(&project, "convert", &["m.cons", "n.cons"], &["--pipeline", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);

    let target = whole.lines().find(|line| line.starts_with("target:")).expect("a target");
    let targets = target.replace("target: ", "targets: { a: ") + ", b: { rest: target.obj } }";
    project.write("p.yaml", &whole.replace(target, &targets));
    let output = markers(&project, "convert", &["m.cons", "o.cons"], &["--pipeline", "p.yaml"]);
    assert_eq!(output.status, 2, "{}", output.stderr);
    assert!(
        output.stderr.contains("p.yaml: the pipeline has several targets (a, b), expected one"),
        "{}",
        output.stderr
    );
    assert!(output.stderr.contains("`--source MESH --target MESH`"), "{}", output.stderr);
}

#[test]
fn points_in_another_unit_or_with_other_axes_are_reported_and_fitted() {
    let project = project("{ source: s.csv, target: t.csv }");
    // Bent, so that no turn brings it onto itself.
    let bent = |[x, y, z]: [f64; 3]| [x, y + 0.1 * z * z, z + 0.2 * y * y];
    let (positions, triangles) = ellipsoid(8, 12);
    let positions: Vec<_> = positions.iter().map(|p| Point3::from(bent([p.x, p.y, p.z]))).collect();
    let doubled: Vec<_> = positions.iter().map(|p| p * 2.0).collect();
    project.write("source.obj", &obj(&positions, &triangles));
    project.write("target.obj", &obj(&doubled, &triangles));
    let rows = |turn: &dyn Fn([f64; 3]) -> [f64; 3]| -> String {
        let row = |v: usize| {
            let [x, y, z] = turn(bent(position(v, 1.0)));
            format!("n{v},{x},{y},{z}\n")
        };
        [5, 17, 40, 52, 70].map(row).concat()
    };
    project.write("t.csv", &rows(&|at| at.map(|x| 2.0 * x)));
    // Centimetres for metres, and an OBJ's axes for Blender's.
    project.write("s.csv", &rows(&|[x, y, z]| [100.0 * x, 100.0 * z, -100.0 * y]));
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 65);
    let expected = "they would fit times 0.01 and turned from Y up to Z up";
    assert!(output.stderr.contains(expected) && output.stderr.contains("--fit"), "{}", output.stderr);
    let options = [&MESHES[..], &["--fit"]].concat();
    let output = markers(&project, "convert", &["s.csv", "t.csv", "fitted.cons"], &options);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(project.read("fitted.cons"), "5\n5, 5\n17, 17\n40, 40\n52, 52\n70, 70\n");
}

#[test]
fn numbers_from_one_are_reported_and_counted_down() {
    let project = project("m.cons");
    let last = ellipsoid(8, 12).0.len();
    project.write("m.cons", &format!("3\n6, 6\n41, 41\n{last}, {last}\n"));
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 65);
    for side in ["source", "target"] {
        let expected = format!("so the numbers of the {side} seem to count from 1");
        assert!(output.stderr.contains(&expected), "{}", output.stderr);
    }
    let output =
        markers(&project, "convert", &["m.cons", "zero.cons"], &[&MESHES[..], &["--from-one", "both"]].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    let end = last - 1;
    assert_eq!(project.read("zero.cons"), format!("3\n5, 5\n40, 40\n{end}, {end}\n"));

    project.write("zero.csv", "nose,0\n");
    for (files, expected) in [
        (&["zero.cons", "again.cons"][..], "error: --from-one: vertex 0, but `--from-one` counts from 1"),
        (&["zero.csv", "zero.csv", "again.cons"], "error: --from-one: it counts the numbers of a .cons or .yaml only"),
    ] {
        project.write("zero.cons", "1\n0, 0\n");
        let output = markers(&project, "convert", files, &[&MESHES[..], &["--from-one", "both"]].concat());
        assert_eq!(output.status, 2, "{}", output.stderr);
        assert!(output.stderr.starts_with(expected), "{}", output.stderr);
        assert!(!project.has("again.cons"));
    }
}

#[test]
fn existing_files_and_wrong_names_are_refused() {
    let project = project("m.cons");
    project.write("m.cons", "1\n5, 5\n");
    for (out, status, expected) in [
        ("m.cons", 73, "error: m.cons: the file is there already"),
        ("x.pp", 2, "error: x.pp: a .pp holds the points of one mesh\n  hint: put `{side}` into its name"),
        ("x-{side}.yaml", 2, "error: x-{side}.yaml: a .yaml holds both sides"),
        ("x.xyz", 2, "error: x.xyz: no notation of markers has this ending"),
    ] {
        let output = markers(&project, "convert", &["m.cons", out], &MESHES);
        assert_eq!((output.status, output.stderr.starts_with(expected)), (status, true), "{}", output.stderr);
    }
    project.write("points.tsv", "nose\t5\n");
    for (files, expected) in [
        (&["points.tsv", "y.yaml"][..], "error: points.tsv: a .tsv holds the points of one mesh only"),
        (&["points.tsv", "m.cons", "y.yaml"], "error: m.cons: this file holds both sides of the markers"),
        (&["points.xyz", "y.yaml"], "error: points.xyz: not a file of markers"),
    ] {
        let output = markers(&project, "convert", files, &MESHES);
        assert_eq!((output.status, output.stderr.starts_with(expected)), (2, true), "{}", output.stderr);
        assert!(!output.stderr.contains("`markers:"), "no pipeline is at hand: {}", output.stderr);
    }
    let output = markers(&project, "convert", &["m.cons", "y.cons"], &[]);
    assert_eq!(output.status, 2);
    assert!(output.stderr.contains("the meshes of the markers are not given"), "{}", output.stderr);
}

#[test]
fn real_markers_come_back_from_every_notation() {
    let Some(pairs) = data("markers/horse_camel.cons") else { return };
    let (Some(source), Some(target)) =
        (data("sumner-horse-poses/horse-reference.obj"), data("sumner-camel-poses/camel-reference.obj"))
    else {
        return;
    };
    let text = std::fs::read_to_string(&pairs).expect("markers");
    let expected = cons::parse(&pairs, &text).expect("markers");
    assert_eq!(expected.pairs.len(), 107);
    let [source, target] = [source, target].map(|mesh| mesh.to_string_lossy().into_owned());
    let project = Project::new();
    project.write("m.cons", &text);
    let meshes = ["--source", &source, "--target", &target];
    for ending in ["pp", "csv", "json", "txt"] {
        let output = markers(&project, "convert", &["m.cons", &format!("{{side}}.{ending}")], &meshes);
        assert_eq!(output.status, 0, "{}", output.stderr);
        let files = ["source", "target"].map(|side| format!("{side}.{ending}"));
        let back = format!("{ending}.cons");
        let output = markers(&project, "convert", &[&files[0], &files[1], &back], &meshes);
        assert_eq!(output.status, 0, "{}", output.stderr);
        let back = cons::parse(Path::new("back.cons"), &project.read(&back)).expect("markers");
        let pairs = |file: &MarkerFile| file.pairs.iter().map(|e| (e.source, e.target)).collect::<Vec<_>>();
        assert_eq!(pairs(&back), pairs(&expected), "{ending}");
    }
}

/// The points of `vertices` in the notation of each of several programs, by the ending of the file.
fn written_elsewhere(vertices: &[usize], factor: f64) -> Vec<(&'static str, String)> {
    let lines = |format: &dyn Fn(usize, [f64; 3]) -> String| -> Vec<String> {
        vertices.iter().enumerate().map(|(i, v)| format(i, position(*v, factor))).collect()
    };
    let places = lines(&|_, [x, y, z]| format!("{x} {y} {z}\n"));
    let count = vertices.len();
    let fcsv = lines(&|i, [x, y, z]| format!("{i},{x},{y},{z},0,0,0,1,1,1,0,n{i},,\n"));
    let controls =
        lines(&|i, at| format!("{{\"label\": \"n{i}\", \"position\": {at:?}, \"positionStatus\": \"defined\"}}"));
    let editor = lines(&|i, [x, y, z]| format!("S{i:03} {x} {y} {z}\n"));
    let markups = format!(
        "{{\"markups\": [{{\"type\": \"Fiducial\", \"coordinateSystem\": \"LPS\", \"controlPoints\": [{}]}}]}}",
        controls.join(",\n")
    );
    let avizo = "Markers { float[3] Coordinates } @1\n\n@1\n";
    vec![
        ("fcsv", format!("# CoordinateSystem = 0\n{}", fcsv.concat())),
        ("mrk.json", markups),
        ("pts", format!("version: 1\nn_points: {count}\n{{\n{}}}\n", places.concat())),
        ("editor.pts", format!("Version 1.0\n{count}\n{}", editor.concat())),
        ("landmarkAscii", format!("# AmiraMesh 3D ASCII 2.0\ndefine Markers {count}\n{avizo}{}", places.concat())),
    ]
}

#[test]
fn points_of_other_programs_lead_to_the_same_vertices() {
    let project = project("m.cons");
    let vertices = [5, 40, 70];
    for ((ending, source), (_, target)) in
        written_elsewhere(&vertices, 1.0).into_iter().zip(written_elsewhere(&vertices, 2.0))
    {
        let files = [format!("s.{ending}"), format!("t.{ending}")];
        project.write(&files[0], &source);
        project.write(&files[1], &target);
        assert_eq!(converted(&project, &[&files[0], &files[1]]), "3\n5, 5\n40, 40\n70, 70\n", "{ending}");
        project.edit("markers: m.cons", &format!("markers: {{ source: {}, target: {} }}", files[0], files[1]));
        let checked = project.mimesh(&["check", "p.yaml"]);
        assert_eq!(checked.status, 0, "{ending}: {}", checked.stderr);
        let by_order = ["pts", "landmarkAscii"].contains(&ending);
        assert_eq!(checked.stdout.contains("markers.pairs"), by_order, "{ending}: {}", checked.stdout);
        project.edit(&format!("markers: {{ source: {}, target: {} }}", files[0], files[1]), "markers: m.cons");
    }
}

#[test]
fn empties_of_a_gltf_are_markers_by_their_names() {
    let project = project("{ source: s.gltf, target: t.gltf }");
    for (file, factor, vertices) in [("s.gltf", 1.0, [5, 40, 70]), ("t.gltf", 2.0, [70, 5, 40])] {
        let nodes = vertices.map(|v| format!("{{ \"name\": \"n{v}\", \"translation\": {:?} }}", position(v, factor)));
        let nodes = nodes.join(", ");
        project.write(
            file,
            &format!(
                "{{ \"asset\": {{ \"version\": \"2.0\" }}, \"scene\": 0, \"scenes\": [{{ \"nodes\": [0, 1, 2, 3] }}], \
                 \"nodes\": [{nodes}, {{ \"name\": \"{file}\" }}] }}"
            ),
        );
    }
    let checked = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(checked.status, 0, "{}", checked.stderr);
    assert!(checked.stdout.contains("3 markers"), "{}", checked.stdout);
    assert_eq!(converted(&project, &["s.gltf", "t.gltf"]), "3\n5, 5\n40, 40\n70, 70\n");
}
