//! The table of docs/formats.md: what each format keeps of a mesh comes back equal, and what it loses is told by name.

mod support;

use std::{collections::BTreeSet, path::Path, sync::Arc};

use mimesh_core::{
    mesh::{CornerAttribute, Image, Material, Mesh, Part},
    stage::{Format, MeshWriter},
    testkit::memory_file::MemoryFile,
};
use mimesh_formats::{Glb, Obj, Off, Ply, Stl};
use nalgebra::Point3;
use support::{grid, read};

/// The least bytes that are known as PNG.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// A mesh of quads with all that a format may keep or lose; with one normal and one place in the image a vertex unless `seams`.
fn furnished(seams: bool) -> Mesh {
    let grid = grid(3);
    // Colours of faces come with a PLY only.
    let mut text = "ply\nformat ascii 1.0\nelement vertex 9\nproperty double x\nproperty double y\nproperty double z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 4\n\
        property list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
        .to_owned();
    grid.positions.iter().enumerate().for_each(|(v, p)| text += &format!("{} {} {} {} 51 0\n", p.x, p.y, p.z, 17 * v));
    grid.polygons.iter().for_each(|c| text += &format!("4 {} {} {} {} 255 {} 0\n", c[0], c[1], c[2], c[3], c[0]));
    let mut mesh = read(&Ply::default(), "a.ply", text.as_bytes()).unwrap().rest;
    let (corners, vertices) = (mesh.polygons.corners().to_vec(), mesh.positions.len());
    let of_vertex = |v: u32| [f64::from(v) / 16.0, 0.25];
    let (values, indices) = if seams {
        let value = |(corner, &v): (usize, &u32)| [of_vertex(v)[0], if corner < 8 { 0.25 } else { 0.75 }];
        (corners.iter().enumerate().map(value).collect(), (0..corners.len() as u32).map(Some).collect())
    } else {
        ((0..vertices as u32).map(of_vertex).collect(), corners.iter().map(|&v| Some(v)).collect::<Vec<_>>())
    };
    mesh.texture_coordinates = Some(CornerAttribute { values, indices });
    let tilted = |corner: usize| Some(u32::from(seams && corner >= 8));
    let normals = vec![[0.0, 0.0, 1.0], [0.0, 0.6, 0.8]];
    mesh.normals = Some(CornerAttribute { values: normals, indices: (0..corners.len()).map(tilted).collect() });
    let part = |group: &str, material: &str, polygons| Part {
        object: Some("Body".into()),
        groups: vec![group.into()],
        material: Some(material.into()),
        polygons,
    };
    mesh.parts = vec![part("left", "skin", 0..2), part("right", "cloth", 2..4)];
    let image = Image { name: "skin.png".into(), contents: Ok(PNG.to_vec()) };
    mesh.materials = vec![
        Material { name: "skin".into(), base_color_image: Some(Arc::new(image)), base_color: [1.0; 4] },
        Material { name: "cloth".into(), base_color: [1.0, 0.5, 0.0, 1.0], base_color_image: None },
    ];
    mesh
}

/// The values of an attribute at the corners of the fans of `mesh`.
fn at_corners<T: Clone>(mesh: &Mesh, attribute: &Option<CornerAttribute<T>>) -> Option<Vec<Option<T>>> {
    let attribute = attribute.as_ref()?;
    let value = |corner: usize| attribute.indices[corner].map(|index| attribute.values[index as usize].clone());
    Some(fan_corners(mesh).into_iter().map(value).collect())
}

/// The corners of the triangles that `mesh` is cut into.
fn fan_corners(mesh: &Mesh) -> Vec<usize> {
    let polygon = |polygon: usize| {
        let range = mesh.polygons.corner_range(polygon);
        let (start, count) = (range.start, range.len());
        (1..count - 1).flat_map(move |k| [start, start + k, start + k + 1])
    };
    (0..mesh.polygons.len()).flat_map(polygon).collect()
}

/// Whether both lists are there and equal to the precision of 32 bits.
fn near<const N: usize>(a: Option<Vec<Option<[f64; N]>>>, b: Option<Vec<Option<[f64; N]>>>) -> bool {
    let close = |(a, b): (&Option<[f64; N]>, &Option<[f64; N]>)| match (a, b) {
        (Some(a), Some(b)) => a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6),
        _ => false,
    };
    matches!((a, b), (Some(a), Some(b)) if a.len() == b.len() && a.iter().zip(&b).all(close))
}

/// What of `mesh` is in `back`, which was written to `bytes` and read again, by the names under which it would be told.
fn kept(mesh: &Mesh, back: &Mesh, bytes: &[u8], seams: bool) -> BTreeSet<&'static str> {
    let names = |mesh: &Mesh, name: fn(&Part) -> Option<String>| -> Vec<Option<String>> {
        let triangles = fan_corners(mesh).len() / 3;
        let cut = triangles / mesh.polygons.len();
        let of_polygon =
            |polygon: usize| mesh.parts.iter().find(|part| part.polygons.contains(&polygon)).and_then(name);
        (0..triangles).map(|triangle| of_polygon(triangle / cut)).collect()
    };
    let same = |name: fn(&Part) -> Option<String>| names(mesh, name) == names(back, name);
    let colors = |mesh: &Mesh| {
        let colors = mesh.vertex_colors.as_ref()?;
        Some(fan_corners(mesh).iter().map(|&c| Some(colors[mesh.polygons.corners()[c] as usize])).collect::<Vec<_>>())
    };
    // Only text shows what no other reader takes up.
    let ply = String::from_utf8_lossy(&write(&Ply::default(), back).0).into_owned();
    let face_colors = ply.split_once("element face").is_some_and(|(_, header)| header.contains("uchar red"));
    let materials = |mesh: &Mesh| mesh.materials.iter().map(|material| material.base_color).collect::<Vec<_>>();
    let textures = bytes.windows(PNG.len()).any(|window| window == PNG);
    let texture_names = ["texture coordinates", "texture coordinates with seams"];
    let normal_names = ["normals", "normals with hard edges"];
    let found = [
        ("polygons of more than three corners", mesh.polygons == back.polygons),
        (
            texture_names[usize::from(seams)],
            near(at_corners(mesh, &mesh.texture_coordinates), at_corners(back, &back.texture_coordinates)),
        ),
        (normal_names[usize::from(seams)], near(at_corners(mesh, &mesh.normals), at_corners(back, &back.normals))),
        ("colours of vertices", near(colors(mesh), colors(back))),
        ("colours of faces", face_colors),
        ("names of objects", same(|part| part.object.clone())),
        ("groups", same(|part| (!part.groups.is_empty()).then(|| part.groups.join(" ")))),
        ("names of materials", same(|part| part.material.clone())),
        ("colours of materials", materials(mesh) == materials(back)),
        ("textures", textures),
    ];
    found.into_iter().filter(|(_, is_kept)| *is_kept).map(|(name, _)| name).collect()
}

/// The file of `mesh` at rest, and what is told.
fn write(format: &dyn Format, mesh: &Mesh) -> (Vec<u8>, Vec<String>) {
    let mut out = Vec::new();
    match format.writer().unwrap() {
        MeshWriter::Pose(writer) => {
            writer.write(mesh, &mesh.positions, &mut out).unwrap();
            (out, writer.warnings(Path::new(""), mesh))
        }
        MeshWriter::Sequence(sequence) => {
            let file = MemoryFile::default();
            let writer = sequence.start(mesh, 0, Box::new(file.clone())).unwrap();
            let warnings = writer.warnings();
            writer.finish().unwrap();
            (file.bytes(), warnings)
        }
    }
}

/// What is told to be left out.
fn told(warnings: &[String]) -> BTreeSet<String> {
    let lists =
        warnings.iter().filter(|warning| warning.starts_with("left out of ")).filter_map(|w| w.split_once(": "));
    lists.flat_map(|(_, names)| names.split(", ")).map(str::to_owned).collect()
}

/// The largest distance between corners.
fn moved(mesh: &Mesh, back: &Mesh) -> f64 {
    let corners = |mesh: &Mesh| -> Vec<Point3<f64>> {
        let at = |c: usize| mesh.positions[mesh.polygons.corners()[c] as usize];
        fan_corners(mesh).into_iter().map(at).collect()
    };
    support::distance(&corners(mesh), &corners(back))
}

#[test]
fn what_is_kept_comes_back_and_what_is_lost_is_told_as_in_the_table() {
    let (obj, ply, stl, off, glb) = (Obj::default(), Ply::default(), Stl::default(), Off::default(), Glb::default());
    let formats: [(&dyn Format, &str, &str); 5] = [
        (&obj, "OBJ", "a.obj"),
        (&glb, "GLB, glTF", "a.glb"),
        (&ply, "PLY", "a.ply"),
        (&off, "OFF", "a.off"),
        (&stl, "STL", "a.stl"),
    ];
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/formats.md")).unwrap();
    for (format, name, file) in formats {
        let (mut all_kept, mut all_lost) = (BTreeSet::new(), BTreeSet::new());
        for seams in [false, true] {
            let mesh = furnished(seams);
            let (bytes, warnings) = write(format, &mesh);
            let back = read(format, file, &bytes).unwrap().rest;
            // 32 bits, for coordinates up to 1.
            assert!(moved(&mesh, &back) <= 1e-6, "{name}");
            let told = told(&warnings);
            let kept = kept(&mesh, &back, &bytes, seams);
            let (seam, edge) = if seams { (" with seams", " with hard edges") } else { ("", "") };
            let contents = [
                "polygons of more than three corners".to_owned(),
                format!("texture coordinates{seam}"),
                format!("normals{edge}"),
                "colours of vertices".into(),
                "colours of faces".into(),
                "names of objects".into(),
                "groups".into(),
                "names of materials".into(),
                "colours of materials".into(),
                "textures".into(),
            ];
            for content in contents {
                let is_kept = kept.contains(&*content);
                // That a glTF holds triangles is known to all who ask for one, and most meshes have quads.
                let silent = name == "GLB, glTF" && content.starts_with("polygons");
                assert!(
                    silent || is_kept != told.contains(&content),
                    "{name}: {content}: kept {is_kept}, told {told:?}"
                );
                if is_kept {
                    all_kept.insert(content)
                } else {
                    all_lost.insert(content)
                };
            }
        }
        let row =
            page.lines().find(|line| line.starts_with(&format!("| {name} |"))).unwrap_or_else(|| panic!("no {name}"));
        let names =
            |cell: &str| cell.split(", ").map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect();
        let cells: Vec<BTreeSet<String>> = row.split('|').map(names).collect();
        assert_eq!(cells[4], all_kept, "{name}: kept");
        assert_eq!(cells[5], all_lost, "{name}: lost");
    }
}
