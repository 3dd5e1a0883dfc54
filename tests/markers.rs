//! Markers from and to other programs, mirrored, and carried to edited meshes, as a user does it.

mod common;

use std::{fmt::Write, path::Path};

use common::{Project, Said};
use mimesh::{
    core::mesh::{Mesh, Surface, SurfacePoint},
    markers::{self, Entry, MarkerFile, Side, cons, mirror, reattach},
};
use nalgebra::Point3;
use proptest::prelude::*;

/// A sphere of `rings` × `sectors` quads, stretched by 1, 2 and 3, exactly symmetric across x = 0.
fn ellipsoid(rings: usize, sectors: usize) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let mut positions = vec![Point3::new(0.0, 0.0, 3.0), Point3::new(0.0, 0.0, -3.0)];
    let half = sectors / 2;
    for ring in 1..rings {
        let polar = std::f64::consts::PI * ring as f64 / rings as f64;
        for sector in 0..sectors {
            // One half is computed, the other its mirror image, so that symmetry holds to the last bit.
            let (k, sign) = if sector < half { (sector, 1.0) } else { (sectors - 1 - sector, -1.0) };
            let angle = std::f64::consts::PI * (k as f64 + 0.5) / half as f64 - std::f64::consts::FRAC_PI_2;
            positions.push(Point3::new(
                sign * polar.sin() * angle.cos(),
                2.0 * polar.sin() * angle.sin(),
                3.0 * polar.cos(),
            ));
        }
    }
    let at = |ring: usize, sector: usize| (2 + (ring - 1) * sectors + sector % sectors) as u32;
    let mut triangles = Vec::new();
    for sector in 0..sectors {
        triangles.push([0, at(1, sector), at(1, sector + 1)]);
        triangles.push([1, at(rings - 1, sector + 1), at(rings - 1, sector)]);
        for ring in 1..rings - 1 {
            let [a, b, c, d] = [at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1), at(ring, sector + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions, triangles)
}

fn mesh(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> (Mesh, Surface) {
    let mesh = Mesh::from_triangles(positions.to_vec(), triangles);
    let surface = Surface::new(&mesh).expect("a surface");
    (mesh, surface)
}

fn obj(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> String {
    let mut text = String::new();
    for p in positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

/// A project whose source is the ellipsoid, and whose target the same twice as large, with its markers `m.*` named in `p.yaml`.
fn project(markers: &str) -> Project {
    let project = Project::new();
    let (positions, triangles) = ellipsoid(8, 12);
    project.write("source.obj", &obj(&positions, &triangles));
    let doubled: Vec<_> = positions.iter().map(|p| p * 2.0).collect();
    project.write("target.obj", &obj(&doubled, &triangles));
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: source.obj, poses: source.obj }}\ntarget: {{ rest: target.obj }}\nmarkers: {markers}\n\
             correspondence: {{ type: identity }}\ntransfer: {{ type: copy_displacement }}\noutput: out/{{pose}}.obj\n"
        ),
    );
    project
}

const MESHES: [&str; 4] = ["--source", "source.obj", "--target", "target.obj"];

fn markers(project: &Project, command: &str, files: &[&str], options: &[&str]) -> Said {
    project.mimesh(&[&["markers", command][..], files, options].concat())
}

/// The vertices of a `.cons` that `files` become.
fn converted(project: &Project, files: &[&str]) -> String {
    let said = markers(project, "convert", &[files, &["out.cons"]].concat(), &[&MESHES[..], &["--force"]].concat());
    assert_eq!(said.status, 0, "{}", said.err);
    project.read("out.cons")
}

fn position(vertex: usize, factor: f64) -> [f64; 3] {
    let p = ellipsoid(8, 12).0[vertex] * factor;
    [p.x, p.y, p.z]
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
    let said = markers(&project, "convert", &["s.pp", "t.csv", "x.yaml"], &MESHES);
    assert!(said.err.contains("warning: s.pp: 1 not active and left out: gone"), "{}", said.err);
    assert!(said.out.contains("source: 3 by position; off the surface by 0.000 % of the diagonal"), "{}", said.out);
}

#[test]
fn what_is_written_is_read_again() {
    let project = project("m.yaml");
    project.write(
        "m.yaml",
        "markers:\n  - { name: \"left ear, tip\", source: 5, target: 6 }\n  \
         - { name: nose, source: { triangle: 20, barycentric: [0.25, 0.5, 0.25] }, target: 41 }\n  - { source: 70, target: { triangle: 30, barycentric: [0.5, 0.25, 0.25] } }\n",
    );
    let said = markers(&project, "convert", &["m.yaml", "first.yaml"], &MESHES);
    assert_eq!(said.status, 0, "{}", said.err);
    let points = |file: &str| -> Vec<(SurfacePoint, Option<SurfacePoint>)> {
        let file = markers::read(&project.path(file)).expect("markers");
        file.entries.iter().map(|entry| (entry.source, entry.target)).collect()
    };
    let expected = points("m.yaml");
    assert_eq!(points("first.yaml"), expected);
    for ending in ["pp", "csv", "json", "txt"] {
        let out = format!("points-{{side}}.{ending}");
        let said = markers(&project, "convert", &["m.yaml", &out], &MESHES);
        assert_eq!(said.status, 0, "{}", said.err);
        let back = format!("{ending}.yaml");
        let files = ["source", "target"].map(|side| format!("points-{side}.{ending}"));
        let said = markers(&project, "convert", &[&files[0], &files[1], &back], &MESHES);
        assert_eq!(said.status, 0, "{ending}: {}", said.err);
        let (source, target) = (mesh_of(1.0), mesh_of(2.0));
        let place = |side: &(Mesh, Surface), point: SurfacePoint| match point {
            SurfacePoint::Vertex(v) => side.0.positions[v as usize],
            point => point.position(&side.1, &side.1.positions),
        };
        for ((s, t), (expected_s, expected_t)) in points(&back).into_iter().zip(&expected) {
            let off = (place(&source, s) - place(&source, *expected_s)).norm()
                + (place(&target, t.expect("a target")) - place(&target, expected_t.expect("a target"))).norm();
            // A few roundings of coordinates of size 6.
            assert!(off < 1e-12, "{ending}: {off}");
        }
    }
}

fn mesh_of(factor: f64) -> (Mesh, Surface) {
    let (positions, triangles) = ellipsoid(8, 12);
    mesh(&positions.iter().map(|p| p * factor).collect::<Vec<_>>(), &triangles)
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
    let said = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert_eq!(said.err, "warning: t.csv: 1 without a partner of that name are left out: n7b\n");
    let said = markers(&project, "convert", &["named.cons"], &["--pipeline", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert_eq!(project.read("named.cons"), "3\n5, 5\n40, 40\n70, 70\n");
    for (from, to, told) in [
        ("target: t.csv }", "taget: t.csv }", "error: p.yaml:3:27: unknown key `taget`"),
        (", target: t.csv }", "}", "error: p.yaml:3:10: missing key `target`"),
        ("target: t.csv }", "target: 3 }", "error: p.yaml:3:35: `target`: expected a text, found 3"),
        ("target: t.csv }", "target: u.csv }", "error: p.yaml:3:35: no such file: u.csv"),
        ("{ source: s.csv, target: t.csv }", "[a, b]", "error: p.yaml:3:10: `markers`: expected a path, or a map"),
        ("{ source: s.csv, target: t.csv }", "s.csv", "error: s.csv: a .csv holds the points of one mesh only"),
    ] {
        let text = project.read("p.yaml");
        project.edit(from, to);
        let said = project.mimesh(&["check", "p.yaml"]);
        assert!(said.err.contains(told), "{told}\n{}", said.err);
        project.write("p.yaml", &text);
    }
}

#[test]
fn points_without_names_are_paired_by_order_if_there_are_as_many() {
    let project = project("m.cons");
    project.write("s.csv", "0,0,3\n0,0,-3\n");
    project.write("t.csv", "a,0,0,-6\nb,0,0,6\n");
    assert_eq!(converted(&project, &["s.csv", "t.csv"]), "2\n0, 1\n1, 0\n");
    project.write("t.csv", "a,0,0,-6\n");
    let said = markers(&project, "convert", &["s.csv", "t.csv", "x.cons"], &MESHES);
    assert_eq!(said.status, 65);
    assert_eq!(
        said.err,
        "error: s.csv: the points cannot be paired: no name is on both sides, and s.csv has 2, t.csv 1\n  hint: call partners \
         alike, or bring as many points in the same order\n"
    );
}

#[test]
fn points_in_another_unit_or_with_other_axes_are_told_and_fitted() {
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
    // Centimetres for metres; Blender's axes for those of an OBJ; both.
    for (text, fit) in [
        (rows(&|at| at.map(|x| 100.0 * x)), "times 0.01:"),
        (rows(&|at| at.map(|x| 0.001 * x)), "times 1000:"),
        (rows(&|[x, y, z]| [x, -z, y]), "turned from Z up to Y up, (x, y, z) to (x, z, -y):"),
        (rows(&|[x, y, z]| [100.0 * x, 100.0 * z, -100.0 * y]), "times 0.01 and turned from Y up to Z up"),
    ] {
        project.write("s.csv", &text);
        let said = project.mimesh(&["check", "p.yaml"]);
        assert_eq!(said.status, 65, "{fit}");
        assert!(said.err.contains(&format!("they would fit {fit}")), "{fit}\n{}", said.err);
        let options = [&MESHES[..], &["--fit", "--force"]].concat();
        let said = markers(&project, "convert", &["s.csv", "t.csv", "fitted.cons"], &options);
        assert_eq!(said.status, 0, "{fit}\n{}", said.err);
        assert_eq!(project.read("fitted.cons"), "5\n5, 5\n17, 17\n40, 40\n52, 52\n70, 70\n", "{fit}");
    }
}

#[test]
fn a_point_astray_is_named_with_both_boxes() {
    let project = project("{ source: s.csv, target: t.csv }");
    project.write("t.csv", "a,0,0,6\nb,0,0,-6\nc,0,0,6\n");
    project.write("s.csv", "a,0,0,3\nb,0,0,-3\nc,9,0,0\n");
    let said = project.mimesh(&["check", "p.yaml"]);
    assert!(
        said.err.starts_with(
            "error: s.csv:3: point c lies 109 % of the diagonal off the source: expected 5 % at most; the points span x 0 to 9, \
             y 0 to 0, z -3 to 3, the source x -0.966 to 0.966, y -1.93 to 1.93, z -3 to 3\n  hint: pick these points again"
        ),
        "{}",
        said.err
    );
}

#[test]
fn exchanged_files_of_points_are_told() {
    let project = project("{ source: t.csv, target: s.csv }");
    let row = |v: usize, factor: f64| {
        let [x, y, z] = position(v, factor);
        format!("n{v},{x},{y},{z}\n")
    };
    project.write("s.csv", &[5, 40, 70].map(|v| row(v, 1.0)).concat());
    project.write("t.csv", &[5, 40, 70].map(|v| row(v, 2.0)).concat());
    let said = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(
        said.err,
        "error: t.csv: the points of t.csv lie on the target, and those of s.csv on the source\n  hint: exchange the two \
         files, or `source` and `target`\n"
    );
}

#[test]
fn numbers_from_one_are_told_and_counted_down() {
    let project = project("m.cons");
    let last = ellipsoid(8, 12).0.len();
    project.write("m.cons", &format!("3\n6, 6\n41, 41\n{last}, {last}\n"));
    let said = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(said.status, 65);
    for side in ["source", "target"] {
        let told = format!("so the numbers of the {side} seem to count from 1");
        assert!(said.err.contains(&told), "{}", said.err);
    }
    let said = markers(&project, "convert", &["m.cons", "zero.cons"], &[&MESHES[..], &["--from-one", "both"]].concat());
    assert_eq!(said.status, 0, "{}", said.err);
    let end = last - 1;
    assert_eq!(project.read("zero.cons"), format!("3\n5, 5\n40, 40\n{end}, {end}\n"));
}

#[test]
fn mirror_completes_a_symmetric_mesh_exactly_and_only_once() {
    let project = project("m.yaml");
    let (positions, _) = ellipsoid(8, 12);
    let partner = |v: usize| {
        let image = Point3::new(-positions[v].x, positions[v].y, positions[v].z);
        positions.iter().position(|p| *p == image).expect("a mirror image")
    };
    project.write(
        "m.yaml",
        &format!(
            "markers:\n  - {{ name: ear_L, source: 5, target: 5 }}\n  - {{ name: chin, source: 0, target: 0 }}\n  - {{ source: 40, target: 40 }}\n  \
             - {{ source: 70, target: 70 }}\n  - {{ source: {0}, target: {0} }}\n",
            partner(70)
        ),
    );
    let said = markers(&project, "mirror", &["m.yaml", "whole.yaml"], &MESHES);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(
        said.out.starts_with(
            "2 added, 2 have a partner, 1 lie on the plane, 0 left alone; 7 markers now\n  ear_L -> ear_R: 0.000 %"
        ),
        "{}",
        said.out
    );
    let whole = markers::read(&project.path("whole.yaml")).expect("markers");
    let added: Vec<_> =
        whole.entries[5..].iter().map(|entry| (entry.name.clone(), entry.source, entry.target)).collect();
    let vertex = |v: usize| SurfacePoint::Vertex(partner(v) as u32);
    assert_eq!(added, [(Some("ear_R".into()), vertex(5), Some(vertex(5))), (None, vertex(40), Some(vertex(40)))]);
    let said = markers(&project, "mirror", &["whole.yaml", "again.yaml"], &MESHES);
    assert!(said.out.starts_with("0 added, 6 have a partner, 1 lie on the plane"), "{}", said.out);
    assert_eq!(project.read("again.yaml"), project.read("whole.yaml"));
    // A plane elsewhere finds nothing on the other side.
    let said = markers(&project, "mirror", &["m.yaml", "off.yaml"], &[&MESHES[..], &["--source-offset=-2"]].concat());
    assert!(said.out.contains("ear_L: left alone, its mirror image lies"), "{}", said.out);
}

#[test]
fn markers_find_their_vertices_on_a_renumbered_mesh() {
    let project = project("m.yaml");
    project.write("m.cons", "3\n5, 5\n40, 40\n70, 70\n");
    assert_eq!(markers(&project, "convert", &["m.cons", "m.yaml"], &MESHES).status, 0);
    let same = markers(&project, "reattach", &["m.yaml", "same.yaml"], &MESHES);
    assert_eq!(same.status, 0, "{}", same.err);
    assert!(same.out.starts_with("source: unchanged\ntarget: unchanged\n"), "{}", same.out);
    assert_eq!(project.read("same.yaml"), project.read("m.yaml"));

    let (positions, triangles) = ellipsoid(8, 12);
    let last = positions.len() as u32 - 1;
    let backwards: Vec<_> = positions.iter().rev().map(|p| p * 2.0).collect();
    let renumbered: Vec<_> = triangles.iter().map(|t| t.map(|v| last - v)).collect();
    project.write("old.obj", &project.read("target.obj"));
    project.write("target.obj", &obj(&backwards, &renumbered));
    project.edit("identity", "nonrigid_fit");
    project.edit("copy_displacement", "gradient");
    let said = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(
        said.err,
        "warning: m.yaml: the target (target.obj) has changed since the markers were made; 3 of 3 points no longer lie where \
         they were put: `mimesh markers reattach` carries them over\n"
    );
    let expected = format!("3\n5, {}\n40, {}\n70, {}\n", last - 5, last - 40, last - 70);
    let said = markers(&project, "reattach", &["m.yaml", "new.cons"], &["--pipeline", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(
        said.out.contains("target: 3 points, the farthest moved by 0.000 % of the diagonal (3), 0 doubtful"),
        "{}",
        said.out
    );
    assert_eq!(project.read("new.cons"), expected);
    // Without positions in the file, the old mesh tells them.
    let said = markers(&project, "reattach", &["m.cons", "other.cons"], &MESHES);
    assert_eq!(said.status, 2);
    assert!(said.err.contains("the markers do not say where their points of the source were"), "{}", said.err);
    let options = [&MESHES[..], &["--old-target", "old.obj"]].concat();
    assert_eq!(markers(&project, "reattach", &["m.cons", "other.cons"], &options).status, 0);
    assert_eq!(project.read("other.cons"), expected);
}

#[test]
fn points_that_move_are_doubtful_and_those_that_are_lost_a_mistake() {
    let project = project("m.yaml");
    project.write("m.cons", "2\n5, 5\n0, 0\n");
    assert_eq!(markers(&project, "convert", &["m.cons", "m.yaml"], &MESHES).status, 0);
    let (mut positions, triangles) = ellipsoid(8, 12);
    // The tip is cut down by 2 % of the diagonal of about 7.5.
    positions[0].z -= 0.15;
    positions.iter_mut().for_each(|p| *p *= 2.0);
    project.write("target.obj", &obj(&positions, &triangles));
    let said = markers(&project, "reattach", &["m.yaml", "new.yaml"], &MESHES);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(said.out.contains("source: unchanged\n"), "{}", said.out);
    assert!(said.out.contains("1 doubtful\n  2: moved by 2.1 % of the diagonal\n"), "{}", said.out);
    positions.iter_mut().for_each(|p| *p *= 100.0);
    project.write("target.obj", &obj(&positions, &triangles));
    let said = markers(&project, "reattach", &["m.yaml", "lost.yaml"], &MESHES);
    assert_eq!(said.status, 65);
    assert!(said.err.contains("they would fit times 100:"), "{}", said.err);
    assert!(!project.has("lost.yaml"));
}

#[test]
fn existing_files_and_wrong_names_are_refused() {
    let project = project("m.cons");
    project.write("m.cons", "1\n5, 5\n");
    for (out, status, told) in [
        ("m.cons", 73, "error: m.cons: the file is there already"),
        ("x.pp", 2, "error: x.pp: a .pp holds the points of one mesh\n  hint: put `{side}` into its name"),
        ("x-{side}.yaml", 2, "error: x-{side}.yaml: a .yaml holds both sides"),
        ("x.xyz", 2, "error: x.xyz: no notation of markers has this ending"),
    ] {
        let said = markers(&project, "convert", &["m.cons", out], &MESHES);
        assert_eq!((said.status, said.err.starts_with(told)), (status, true), "{}", said.err);
    }
    let said = markers(&project, "convert", &["m.cons", "y.cons"], &[]);
    assert_eq!(said.status, 2);
    assert!(said.err.contains("the meshes of the markers are not given"), "{}", said.err);
}

/// An ellipsoid with dents, symmetric no more.
fn dented(factor: f64, dents: &[f64]) -> (Mesh, Surface) {
    let (mut positions, triangles) = ellipsoid(8, 12);
    for (i, p) in positions.iter_mut().enumerate() {
        *p *= factor * (1.0 + dents[i % dents.len()]);
    }
    mesh(&positions, &triangles)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn mirroring_twice_adds_nothing_to_mirroring_once(
        dents in prop::collection::vec(-0.08..0.08f64, 1..40),
        vertices in prop::collection::btree_set(0_u32..86, 1..12),
        shift in 0_u32..86,
    ) {
        let (source, target) = (dented(1.0, &dents), dented(2.0, &dents[dents.len() / 2..]));
        let sides = [
            Side { name: "source", mesh: &source.0, surface: &source.1 },
            Side { name: "target", mesh: &target.0, surface: &target.1 },
        ];
        let entries = vertices.iter().map(|&v| {
            let name = (v % 3 == 0).then(|| format!("n{v}{}", ["_L", "_R", ""][v as usize / 3 % 3]));
            Entry { name, ..Entry::new(SurfacePoint::Vertex(v), SurfacePoint::Vertex(if shift < 20 { (v + shift) % 86 } else { v })) }
        });
        let file = MarkerFile { entries: entries.collect(), ..MarkerFile::default() };
        let planes = sides.map(|side| mirror::Plane::middle(side, 0));
        let once = mirror::mirror(&file, sides, planes).unwrap().markers;
        let twice = mirror::mirror(&once, sides, planes).unwrap().markers;
        prop_assert_eq!(&once.entries[..file.entries.len()], &file.entries[..]);
        prop_assert_eq!(once, twice);
    }

    #[test]
    fn on_the_same_mesh_nothing_moves(
        points in prop::collection::vec((0_u32..144, 0.0..0.5f64, 0.0..0.5f64), 1..10),
    ) {
        let (source, target) = (mesh_of(1.0), mesh_of(2.0));
        let point = |(t, u, v): (u32, f64, f64)| {
            if t % 2 == 0 { SurfacePoint::Vertex(t % 86) } else { SurfacePoint::Triangle(t, [u, v, 1.0 - u - v]) }
        };
        let entries: Vec<_> = points.into_iter().map(|p| Entry::new(point(p), point(p))).collect();
        let mut file = MarkerFile { entries, ..MarkerFile::default() };
        let before = file.clone();
        for (name, (mesh, surface)) in [("source", &source), ("target", &target)] {
            let side = Side { name, mesh, surface };
            let moves = reattach::reattach(&mut file, Some(side), side, false).unwrap();
            prop_assert!(moves.iter().all(|moved| moved.distance == 0.0 && moved.doubt.is_none()));
        }
        for (a, b) in file.entries.iter().zip(&before.entries) {
            prop_assert_eq!((a.source, a.target), (b.source, b.target));
        }
    }
}

#[test]
fn real_markers_come_back_from_every_notation() {
    let Some(data) = common::data() else { return };
    let text = std::fs::read_to_string(data.join("markers/horse_camel.cons")).expect("markers");
    let expected = cons::parse(Path::new("horse_camel.cons"), &text).expect("markers");
    let meshes = ["sumner-horse-poses/horse-reference.obj", "sumner-camel-poses/camel-reference.obj"];
    let [source, target] = meshes.map(|mesh| data.join(mesh).to_string_lossy().into_owned());
    if !Path::new(&source).exists() || !Path::new(&target).exists() {
        eprintln!("skipped: the meshes of the markers are missing");
        return;
    }
    let project = Project::new();
    project.write("m.cons", &text);
    let meshes = ["--source", &source, "--target", &target];
    for ending in ["pp", "csv", "json", "txt"] {
        let said = markers(&project, "convert", &["m.cons", &format!("{{side}}.{ending}")], &meshes);
        assert_eq!(said.status, 0, "{}", said.err);
        let files = ["source", "target"].map(|side| format!("{side}.{ending}"));
        let back = format!("{ending}.cons");
        let said = markers(&project, "convert", &[&files[0], &files[1], &back], &meshes);
        assert_eq!(said.status, 0, "{}", said.err);
        let back = cons::parse(Path::new("back.cons"), &project.read(&back)).expect("markers");
        let pairs = |file: &MarkerFile| file.entries.iter().map(|e| (e.source, e.target)).collect::<Vec<_>>();
        assert_eq!(pairs(&back), pairs(&expected), "{ending}");
    }
}
