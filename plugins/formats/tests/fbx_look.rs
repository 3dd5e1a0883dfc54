//! FBX: colours of vertices, and materials with their images.

mod support;

use mimesh_core::{
    mesh::MeshSequence,
    stage::{BytesInput, Format, MeshWriter, Selection},
};
use mimesh_formats::{Fbx, Ply};
use support::fbx::{
    Record,
    Value::{Bytes, Double, Doubles, Int, Ints, Long, Name, Text},
    binary, leaf, model, properties, property,
};

/// A layer of a mesh with values of corners.
fn corners(kind: &'static str, number: i32, values: &'static str, indices: &'static str, of: Vec<f64>) -> Record {
    Record(
        kind,
        vec![Int(number)],
        vec![
            leaf("Version", Int(101)),
            leaf("Name", Text(format!("{kind}-{number}"))),
            leaf("MappingInformationType", Text("ByPolygonVertex".into())),
            leaf("ReferenceInformationType", Text("IndexToDirect".into())),
            leaf(values, Doubles(of)),
            leaf(indices, Ints(vec![0, 1, 2, 0, 2, 3])),
        ],
    )
}

fn layer(number: i32, kinds: &[&str]) -> Record {
    let element = |kind: &&str| {
        let kind = leaf("Type", Text((*kind).into()));
        Record("LayerElement", vec![], vec![kind, leaf("TypedIndex", Int(number))])
    };
    let version = leaf("Version", Int(100));
    Record("Layer", vec![Int(number)], [version].into_iter().chain(kinds.iter().map(element)).collect())
}

/// Two triangles of a square with colours at corners and two sets of texture coordinates, and a material that shows `face.png`, whose
/// contents are in the file if there are any.
fn square(colors: Vec<f64>, embedded: Option<&[u8]>) -> Vec<u8> {
    let material = layer_of_material();
    let square = Record(
        "Geometry",
        vec![Long(1), Name("squareMesh", "Geometry"), Text("Mesh".into())],
        vec![
            leaf("Vertices", Doubles(vec![0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.])),
            leaf("PolygonVertexIndex", Ints(vec![0, 1, -3, 0, 2, -4])),
            corners("LayerElementUV", 0, "UV", "UVIndex", vec![0., 0., 1., 0., 1., 1., 0., 1.]),
            corners("LayerElementUV", 1, "UV", "UVIndex", vec![0.; 8]),
            corners("LayerElementColor", 0, "Colors", "ColorIndex", colors),
            material,
            layer(0, &["LayerElementUV", "LayerElementColor", "LayerElementMaterial"]),
            layer(1, &["LayerElementUV"]),
        ],
    );
    let skin = Record(
        "Material",
        vec![Long(2), Name("skin", "Material"), Text(String::new())],
        vec![
            leaf("ShadingModel", Text("lambert".into())),
            properties(vec![property("DiffuseColor", "Color", [Double(0.5), Double(0.25), Double(1.0)])]),
        ],
    );
    let names = || {
        vec![
            leaf("Filename", Text("C:\\\\art\\\\face.png".into())),
            leaf("RelativeFilename", Text("art/face.png".into())),
        ]
    };
    let texture = Record("Texture", vec![Long(3), Name("face", "Texture"), Text(String::new())], names());
    let contents = embedded.map(|contents| leaf("Content", Bytes(contents.into())));
    let video = Record(
        "Video",
        vec![Long(4), Name("face", "Video"), Text("Clip".into())],
        names().into_iter().chain(contents).collect(),
    );
    let connect = |from, to| Record("C", vec![Text("OO".into()), Long(from), Long(to)], vec![]);
    let color = Record("C", vec![Text("OP".into()), Long(3), Long(2), Text("DiffuseColor".into())], vec![]);
    let connections = vec![connect(10, 0), connect(1, 10), connect(2, 10), connect(4, 3), color];
    binary(&[
        Record("FBXHeaderExtension", vec![], vec![leaf("FBXHeaderVersion", Int(1003)), leaf("FBXVersion", Int(7400))]),
        Record(
            "GlobalSettings",
            vec![],
            vec![leaf("Version", Int(1000)), properties(vec![property("UnitScaleFactor", "double", [Double(100.0)])])],
        ),
        Record(
            "Objects",
            vec![],
            vec![square, model(10, "square", "Mesh", [0.; 3], [0.; 3], [1.; 3]), skin, texture, video],
        ),
        Record("Connections", vec![], connections),
    ])
}

fn layer_of_material() -> Record {
    Record(
        "LayerElementMaterial",
        vec![Int(0)],
        vec![
            leaf("Version", Int(101)),
            leaf("Name", Text(String::new())),
            leaf("MappingInformationType", Text("AllSame".into())),
            leaf("ReferenceInformationType", Text("IndexToDirect".into())),
            leaf("Materials", Ints(vec![0])),
        ],
    )
}

fn read(bytes: &[u8], keep_document: bool) -> MeshSequence {
    let selection = Selection { keep_document, ..Selection::default() };
    Fbx::default().read(&BytesInput::new("a.fbx", bytes), &selection).unwrap()
}

/// One colour a vertex.
const COLORS: [[f64; 4]; 4] = [[1., 0., 0., 1.], [0., 1., 0., 1.], [0., 0., 1., 0.5], [0.25, 0.5, 0.75, 1.]];

#[test]
fn colours_of_vertices_and_images_in_the_file_are_read() {
    let bytes = square(COLORS.concat(), Some(b"an image"));
    let mesh = read(&bytes, true).rest;
    assert_eq!(mesh.vertex_colors.as_deref(), Some(&COLORS[..]));
    let [material] = &mesh.materials[..] else { panic!("one material") };
    assert_eq!((&material.name[..], material.base_color), ("skin", [0.5, 0.25, 1.0, 1.0]));
    let image = material.base_color_image.as_deref().expect("an image");
    assert_eq!((&image.name[..], image.contents.as_deref()), ("face.png", Ok(&b"an image"[..])));
    // A source is not written, so its images are not read.
    assert!(read(&bytes, false).rest.materials[0].base_color_image.is_none());
}

#[test]
fn an_image_that_is_not_there_is_named_and_what_does_not_fit_is_told() {
    let mesh = read(&square(COLORS.concat(), None), true).rest;
    let image = mesh.materials[0].base_color_image.as_deref().expect("an image");
    assert_eq!(image.name, "face.png");
    assert!(image.contents.is_err());
    // The second set of texture coordinates has no place.
    let ply = Ply::default();
    let MeshWriter::Pose(writer) = ply.writer().unwrap() else { panic!("one file a pose") };
    let told = writer.warnings(std::path::Path::new(""), &mesh).concat();
    assert!(told.contains("further texture coordinates") && !told.contains("corners of a vertex"), "{told}");
}
