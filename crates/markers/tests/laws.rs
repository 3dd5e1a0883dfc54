//! Laws of mirroring, reattaching and exporting, and that damaged files are refused without a panic.

mod common;

use std::path::Path;

use common::{both, dented, pair};
use mimesh_core::mesh::MeshPoint;
use mimesh_markers::{
    MarkerFile, MarkerPair, MeshRole, Plane, PointFile, PointSource, export, formats, mirror, read_markers,
    read_points, reattach,
};
use proptest::prelude::*;

/// A point of the ellipsoid: a vertex, or a place on a triangle.
fn point() -> impl Strategy<Value = MeshPoint> {
    prop_oneof![
        (0_u32..86).prop_map(MeshPoint::Vertex),
        (0_u32..168, 0.0..0.5f64, 0.0..0.5f64).prop_map(|(t, u, v)| MeshPoint::Triangle(t, [u, v, 1.0 - u - v])),
    ]
}

/// Texts of every notation, to be damaged.
const FILES: [(&str, &str); 14] = [
    ("m.cons", "2\n750, 3386\n524 3737\n"),
    (
        "m.yaml",
        "source: { mesh: a.obj, vertices: 9 }\nmarkers:\n  - { name: ear, source: 750, target: { vertex: 4, at: [1, 2, 3] } }\n  \
         - { source: { triangle: 12, barycentric: [0.2, 0.3, 0.5] }, target: null, note: \"t\u{e9}\" }\n",
    ),
    (
        "m.pp",
        "<!DOCTYPE PickedPoints>\n<PickedPoints>\n <!-- two -->\n <point y=\"2\" name=\"a &amp; \u{e9}\" x=\"1\" active=\"1\" z=\"3e-1\"/>\n \
         <point x='0' y='0' z='0' active='0'></point>\n</PickedPoints>\n",
    ),
    ("wrap.json", "[[42, 0.25, 0.5], [1337, 0.0, 1.0]]"),
    (
        "names.json",
        "{\"points\": {\"nose\": [0.5, 2, 3], \"ear\": [12, 13, 14, 15], \"t\\u00e9\": {\"x\": 1, \"y\": 2, \"z\": 3}}}",
    ),
    (
        "list.json",
        "[{\"name\": \"nose\", \"position\": [1, 2, 3]},\n {\"name\": \"b\", \"triangle\": 3, \"barycentric\": [0.5, 0.25]}]",
    ),
    ("m.csv", "name,x,y,z\n\"left, \u{e9}\", 1, 2.5, -3\n# a remark\n\nnose,1e-3,0,7\n"),
    ("m.tsv", "---\tIdentifier\tVertexIndex\nRow_0\tnose\t7\n"),
    ("m.txt", "nose 1  2.5 -3\n\"left ear\" 0 1e-3 7\n"),
    (
        "m.fcsv",
        "# CoordinateSystem = LPS\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n\
         1,1,2.5,-3,0,0,0,1,1,1,0,\"left, \u{e9}\",,\n2,0,1e-3,7,0,0,0,1,1,1,0,nose,,,2,0\n",
    ),
    (
        "m.mrk.json",
        "{\"markups\": [{\"type\": \"Fiducial\", \"coordinateSystem\": \"LPS\", \"controlPoints\": [\n{\"label\": \"nose\", \
         \"position\": [1, 2.5, -3], \"positionStatus\": \"defined\"}, {\"label\": \"\", \"position\": [0, 1e-3, 7]}]}]}",
    ),
    ("editor.pts", "Version 1.0\n2\nS000 1 2.5 -3\nS001 9999 9999 9999\n"),
    ("m.pts", "version: 1\nn_points: 2\n{\n1 2.5 -3\n0 1e-3 7\n}\n"),
    (
        "m.am",
        "# AmiraMesh 3D ASCII 2.0\ndefine Markers 2\nParameters { NumSets 1 }\nMarkers { float[3] Coordinates } @1\n\n@1\n1 2.5 -3\n\
         0 1e-3 7\n",
    ),
];

/// What happens to some bytes of a file.
#[derive(Clone, Debug)]
enum Damage {
    Replace(u8),
    Insert(u8),
    Cut(usize),
    Repeat(usize),
    Truncate,
}

fn damage() -> impl Strategy<Value = Damage> {
    let byte = prop_oneof![any::<u8>(), prop::sample::select(&b"\"'<>[]{},;:.&#-+e0\\/ \t\r\n"[..])];
    prop_oneof![
        byte.clone().prop_map(Damage::Replace),
        byte.prop_map(Damage::Insert),
        (1_usize..20).prop_map(Damage::Cut),
        (1_usize..20).prop_map(Damage::Repeat),
        Just(Damage::Truncate),
    ]
}

fn damaged(text: &str, damages: &[(prop::sample::Index, Damage)]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (place, damage) in damages {
        let at = place.index(bytes.len() + 1);
        let end = |length: usize| (at + length).min(bytes.len());
        match damage {
            Damage::Replace(byte) => drop(bytes.splice(at..end(1), [*byte])),
            Damage::Insert(byte) => bytes.insert(at, *byte),
            Damage::Cut(length) => drop(bytes.drain(at..end(*length))),
            Damage::Repeat(length) => {
                let part = bytes[at..end(*length)].to_vec();
                drop(bytes.splice(at..at, part));
            }
            Damage::Truncate => bytes.truncate(at),
        }
    }
    bytes
}

/// Whether the file is read, or refused with a message in it.
fn read_or_refused(file: &Path) -> bool {
    let failure = match mimesh_markers::is_point_file(file) {
        true => read_points(file).err(),
        false => read_markers(file).err(),
    };
    let text = failure.map(|failure| failure.to_string());
    text.is_none_or(|text| text.starts_with(&format!("error: {}", file.display())))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn mirroring_twice_adds_nothing_to_mirroring_once(
        dents in prop::collection::vec(-0.08..0.08f64, 1..40),
        vertices in prop::collection::btree_set(0_u32..86, 1..12),
        shift in 0_u32..86,
    ) {
        let meshes = [dented(1.0, &dents), dented(2.0, &dents[dents.len() / 2..])];
        let meshes = both(&meshes);
        let pairs = vertices.iter().map(|&v| {
            let name = (v % 3 == 0).then(|| format!("n{v}{}", ["_L", "_R", ""][v as usize / 3 % 3]));
            let target = if shift < 20 { (v + shift) % 86 } else { v };
            MarkerPair { name, ..MarkerPair::new(MeshPoint::Vertex(v), MeshPoint::Vertex(target)) }
        });
        let file = MarkerFile { pairs: pairs.collect(), ..MarkerFile::default() };
        let planes = meshes.map(|mesh| Plane::middle(mesh, 0));
        let once = mirror(&file, meshes, planes).unwrap().markers;
        let twice = mirror(&once, meshes, planes).unwrap().markers;
        prop_assert_eq!(&once.pairs[..file.pairs.len()], &file.pairs[..]);
        prop_assert_eq!(once, twice);
    }

    #[test]
    fn on_the_same_mesh_nothing_moves(points in prop::collection::vec(point(), 1..10)) {
        let meshes = pair();
        let pairs: Vec<_> = points.into_iter().map(|p| MarkerPair::new(p, p)).collect();
        let mut file = MarkerFile { pairs, ..MarkerFile::default() };
        let before = file.clone();
        for mesh in both(&meshes) {
            let moves = reattach(&mut file, Some(mesh), mesh, false).unwrap();
            prop_assert!(moves.iter().all(|moved| moved.distance == 0.0 && moved.doubt.is_none()));
        }
        for (a, b) in file.pairs.iter().zip(&before.pairs) {
            prop_assert_eq!((a.source, a.target), (b.source, b.target));
        }
    }

    #[test]
    fn exported_points_come_back_where_they_were(points in prop::collection::vec(point(), 1..10)) {
        let meshes = pair();
        let meshes = both(&meshes);
        let mut file = MarkerFile::default();
        for (i, point) in points.iter().enumerate() {
            file.pairs.push(MarkerPair { name: Some(format!("n{i}")), ..MarkerPair::new(*point, *point) });
        }
        for ending in ["pp", "json", "txt", "csv"] {
            let exported = export(&file, Path::new(&format!("points-{{side}}.{ending}")), meshes).unwrap();
            let names: Vec<_> = exported.files.iter().map(|(path, _)| path.display().to_string()).collect();
            prop_assert_eq!(names, ["source", "target"].map(|side| format!("points-{side}.{ending}")));
            let parse = |i: usize| -> PointFile {
                mimesh_markers::read::parse_points(&exported.files[i].0, &exported.files[i].1).unwrap()
            };
            let attached = PointSource::Sides([parse(0), parse(1)]).attach(meshes, false).unwrap();
            prop_assert!(attached.warnings.is_empty());
            for (back, pair) in attached.markers.pairs.iter().zip(&file.pairs) {
                for mesh in meshes {
                    let position = |pair: &MarkerPair| mesh.position(pair.point(mesh.role).unwrap()).unwrap();
                    // Points within 1e-5 of the diagonal of a vertex snap to it; the diagonal is 7.5 or 15.
                    prop_assert!((position(back) - position(pair)).norm() < 2e-4, "{}", ending);
                }
            }
        }
    }

    #[test]
    fn vertices_come_back_from_every_notation(vertices in prop::collection::btree_set(0_u32..86, 1..10)) {
        let meshes = pair();
        let meshes = both(&meshes);
        let mut file = MarkerFile::default();
        file.pairs.extend(vertices.into_iter().map(|v| MarkerPair::new(MeshPoint::Vertex(v), MeshPoint::Vertex(85 - v))));
        let points = |file: &MarkerFile| file.pairs.iter().map(|pair| (pair.source, pair.target)).collect::<Vec<_>>();
        for ending in ["pp", "json", "txt", "csv"] {
            let exported = export(&file, Path::new(&format!("{{side}}.{ending}")), meshes).unwrap();
            let [source, target] = &exported.files[..] else { panic!("two files") };
            let files = [source, target].map(|(path, text)| mimesh_markers::read::parse_points(path, text).unwrap());
            let attached = PointSource::Sides(files).attach(meshes, false).unwrap();
            // Wrap's notation has corners of triangles in place of vertices.
            let back = export(&attached.markers, Path::new("back.cons"), meshes).unwrap();
            prop_assert!(back.warnings.is_empty());
            let back = formats::cons::parse(Path::new("back.cons"), &back.files[0].1).unwrap();
            prop_assert_eq!(points(&back), points(&file), "{}", ending);
        }
        let text = &export(&file, Path::new("m.cons"), meshes).unwrap().files[0].1;
        prop_assert_eq!(points(&formats::cons::parse(Path::new("m.cons"), text).unwrap()), points(&file));
        file.record_positions(meshes, [None; 2]);
        let text = &export(&file, Path::new("m.yaml"), meshes).unwrap().files[0].1;
        let mut back = formats::yaml::parse(Path::new("m.yaml"), text).unwrap();
        back.pairs.iter_mut().for_each(|pair| pair.location = None);
        prop_assert_eq!(back, file);
    }

    #[test]
    fn markers_follow_a_renumbered_mesh(vertices in prop::collection::btree_set(0_u32..86, 1..10), with_old in any::<bool>()) {
        let meshes = pair();
        let meshes = both(&meshes);
        let (positions, triangles) = common::ellipsoid();
        let backwards = positions.into_iter().rev().collect();
        let edited = common::Meshed::new(backwards, &triangles.iter().map(|t| t.map(|v| 85 - v)).collect::<Vec<_>>());
        let mut file = MarkerFile::default();
        file.pairs.extend(vertices.iter().map(|&v| MarkerPair::new(MeshPoint::Vertex(v), MeshPoint::Vertex(v))));
        let old = with_old.then_some(meshes[0]);
        if !with_old {
            file.record_positions(meshes, [None; 2]);
        }
        let moves = reattach(&mut file, old, edited.on(MeshRole::Source), false).unwrap();
        prop_assert!(moves.iter().all(|moved| moved.distance == 0.0 && moved.doubt.is_none()));
        let sources: Vec<_> = file.pairs.iter().map(|pair| pair.source).collect();
        let expected: Vec<_> = vertices.iter().map(|&v| Some(MeshPoint::Vertex(85 - v))).collect();
        prop_assert_eq!(sources, expected);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_files_are_read_or_refused(
        file in prop::sample::select(&FILES[..]),
        damages in prop::collection::vec((any::<prop::sample::Index>(), damage()), 0..5),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(file.0);
        std::fs::write(&path, damaged(file.1, &damages)).unwrap();
        prop_assert!(read_or_refused(&path));
    }

    #[test]
    fn files_of_any_bytes_are_read_or_refused(
        file in prop::sample::select(&FILES[..]),
        bytes in prop::collection::vec(any::<u8>(), 0..60),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(file.0);
        std::fs::write(&path, bytes).unwrap();
        prop_assert!(read_or_refused(&path));
    }
}
