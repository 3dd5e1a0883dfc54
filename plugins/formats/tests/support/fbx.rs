//! A small FBX, binary or ASCII: the strip of the glTF tests with skin, blend shape and clip.

use std::fmt::Write;

use super::gltf::STRIP;

/// A value of a record.
#[derive(Clone)]
pub enum Value {
    /// A whole number of 64 bits.
    Long(i64),
    /// A whole number of 32 bits.
    Int(i32),
    /// A number.
    Double(f64),
    /// Text.
    Text(String),
    /// The name of an object, and its class.
    Name(&'static str, &'static str),
    /// Whole numbers of 32 bits.
    Ints(Vec<i32>),
    /// Whole numbers of 64 bits.
    Longs(Vec<i64>),
    /// Numbers.
    Doubles(Vec<f64>),
    /// Numbers of 32 bits.
    Floats(Vec<f32>),
    /// The contents of a file, in binary files only.
    Bytes(Vec<u8>),
}

use Value::{Bytes, Double, Doubles, Floats, Int, Ints, Long, Longs, Name, Text};

/// A record of an FBX.
pub struct Record(pub &'static str, pub Vec<Value>, pub Vec<Record>);

/// A record of one value.
pub fn leaf(name: &'static str, value: Value) -> Record {
    Record(name, vec![value], vec![])
}

/// A property with its type.
pub fn property(name: &str, kind: &str, values: impl IntoIterator<Item = Value>) -> Record {
    let head = [name, kind, "", ""].map(|text| Text(text.into()));
    Record("P", head.into_iter().chain(values).collect(), vec![])
}

/// The record of properties.
pub fn properties(all: Vec<Record>) -> Record {
    Record("Properties70", vec![], all)
}

/// A node.
pub fn model(
    id: i64,
    name: &'static str,
    kind: &str,
    translation: [f64; 3],
    rotation: [f64; 3],
    scale: [f64; 3],
) -> Record {
    let vectors = [("Lcl Translation", translation), ("Lcl Rotation", rotation), ("Lcl Scaling", scale)];
    let vectors = vectors.map(|(name, vector)| property(name, name, vector.map(Double)));
    Record("Model", vec![Long(id), Name(name, "Model"), Text(kind.into())], vec![properties(vectors.into())])
}

fn moved(at: [f64; 3]) -> Value {
    let [x, y, z] = at;
    Doubles(vec![1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, y, z, 1.])
}

/// The unit and axes of a file.
#[derive(Clone, Copy)]
pub enum Space {
    /// Metres with Y up.
    MetresYUp,
    /// Centimetres with Z up.
    CentimetresZUp,
}

/// The strip: its skin is bound straight, its upper joint turns by 90° from 0 to 1 s, `lift` raises its last two vertices by 1.
///
/// `stored_degrees` turn the upper joint in the file itself. A mirrored triangle `hat` hangs on that joint, one unit above it.
pub fn strip(space: Space, stored_degrees: f64) -> Vec<Record> {
    let place = |[x, y, z]: [f64; 3]| match space {
        Space::MetresYUp => [x, y, z],
        Space::CentimetresZUp => [100.0 * x, -100.0 * z, 100.0 * y],
    };
    // Turning about Z with Y up is turning about −Y with Z up.
    let (axis, sign) = match space {
        Space::MetresYUp => ("d|Z", 1.0),
        Space::CentimetresZUp => ("d|Y", -1.0),
    };
    let turn = |degrees: f64| if axis == "d|Z" { [0., 0., degrees] } else { [0., sign * degrees, 0.] };
    let all = |points: &[[f64; 3]]| Doubles(points.iter().flat_map(|point| place(*point)).collect());
    let up = |height: f64| place([0., height, 0.]);
    let axes = match space {
        Space::MetresYUp => [1, 1, 2, 1, 0, 1],
        Space::CentimetresZUp => [2, 1, 1, -1, 0, 1],
    };
    let names = ["UpAxis", "UpAxisSign", "FrontAxis", "FrontAxisSign", "CoordAxis", "CoordAxisSign"];
    let mut settings: Vec<Record> =
        names.into_iter().zip(axes).map(|(name, value)| property(name, "int", [Int(value)])).collect();
    let unit = if matches!(space, Space::MetresYUp) { 100.0 } else { 1.0 };
    settings.push(property("UnitScaleFactor", "double", [Double(unit)]));
    let uv = Record(
        "LayerElementUV",
        vec![Int(0)],
        vec![
            leaf("Version", Int(101)),
            leaf("Name", Text("UV".into())),
            leaf("MappingInformationType", Text("ByPolygonVertex".into())),
            leaf("ReferenceInformationType", Text("IndexToDirect".into())),
            leaf("UV", Doubles(vec![0., 0., 1., 0., 1., 1., 0., 1.])),
            leaf("UVIndex", Ints(vec![0, 1, 2, 3, 0, 1, 2, 3])),
        ],
    );
    let layer = Record(
        "Layer",
        vec![Int(0)],
        vec![
            leaf("Version", Int(100)),
            Record(
                "LayerElement",
                vec![],
                vec![leaf("Type", Text("LayerElementUV".into())), leaf("TypedIndex", Int(0))],
            ),
        ],
    );
    let geometry = |id, name, kind: &str, records| {
        Record("Geometry", vec![Long(id), Name(name, "Geometry"), Text(kind.into())], records)
    };
    let cluster = |id, name, vertices: Vec<i32>, weights: Vec<f64>, height: f64| {
        Record(
            "Deformer",
            vec![Long(id), Name(name, "SubDeformer"), Text("Cluster".into())],
            vec![
                leaf("Version", Int(100)),
                leaf("Indexes", Ints(vertices)),
                leaf("Weights", Doubles(weights)),
                leaf("Transform", moved(up(-height))),
                leaf("TransformLink", moved(up(height))),
            ],
        )
    };
    let second = 46_186_158_000;
    let objects = vec![
        geometry(
            1,
            "stripMesh",
            "Mesh",
            vec![
                leaf("Vertices", all(&STRIP)),
                // Two quads; the last corner of each is −1 − its vertex.
                leaf("PolygonVertexIndex", Ints(vec![0, 1, 3, -3, 2, 3, 5, -5])),
                uv,
                layer,
            ],
        ),
        geometry(
            2,
            "lift",
            "Shape",
            vec![
                leaf("Version", Int(100)),
                leaf("Indexes", Ints(vec![4, 5])),
                leaf("Vertices", all(&[[0., 1., 0.], [0., 1., 0.]])),
            ],
        ),
        geometry(
            3,
            "hatMesh",
            "Mesh",
            vec![
                leaf("Vertices", all(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]])),
                leaf("PolygonVertexIndex", Ints(vec![0, 1, -3])),
            ],
        ),
        // A mesh that is skinned goes with its joints alone.
        model(10, "strip", "Mesh", [0.; 3], [0.; 3], [1.; 3]),
        model(11, "lower", "LimbNode", [0.; 3], [0.; 3], [1.; 3]),
        model(12, "upper", "LimbNode", up(1.0), turn(stored_degrees), [1.; 3]),
        model(13, "hat", "Mesh", up(1.0), [0.; 3], [-1., 1., 1.]),
        Record(
            "Deformer",
            vec![Long(20), Name("skin", "Deformer"), Text("Skin".into())],
            vec![leaf("Version", Int(101))],
        ),
        cluster(21, "lower", vec![0, 1, 2, 3], vec![1., 1., 0.5, 0.5], 0.0),
        cluster(22, "upper", vec![2, 3, 4, 5], vec![0.5, 0.5, 1., 1.], 1.0),
        Record(
            "Deformer",
            vec![Long(23), Name("shapes", "Deformer"), Text("BlendShape".into())],
            vec![leaf("Version", Int(100))],
        ),
        Record(
            "Deformer",
            vec![Long(24), Name("lift", "SubDeformer"), Text("BlendShapeChannel".into())],
            vec![
                leaf("Version", Int(100)),
                leaf("DeformPercent", Double(0.0)),
                leaf("FullWeights", Doubles(vec![100.0])),
            ],
        ),
        Record(
            "AnimationStack",
            vec![Long(30), Name("Rig|Turn", "AnimStack"), Text(String::new())],
            vec![properties(vec![
                property("LocalStart", "KTime", [Long(0)]),
                property("LocalStop", "KTime", [Long(second)]),
            ])],
        ),
        Record("AnimationLayer", vec![Long(31), Name("Base", "AnimLayer"), Text(String::new())], vec![]),
        Record(
            "AnimationCurveNode",
            vec![Long(32), Name("R", "AnimCurveNode"), Text(String::new())],
            vec![properties(vec![property(axis, "Number", [Double(0.0)])])],
        ),
        Record(
            "AnimationCurve",
            vec![Long(33), Name("", "AnimCurve"), Text(String::new())],
            vec![
                leaf("Default", Double(0.0)),
                leaf("KeyVer", Int(4009)),
                leaf("KeyTime", Longs(vec![0, second])),
                leaf("KeyValueFloat", Floats(vec![0.0, 90.0 * sign as f32])),
                // 4 is linear.
                leaf("KeyAttrFlags", Ints(vec![4])),
                leaf("KeyAttrDataFloat", Floats(vec![0.0; 4])),
                leaf("KeyAttrRefCount", Ints(vec![2])),
            ],
        ),
    ];
    let connect = |from, to| Record("C", vec![Text("OO".into()), Long(from), Long(to)], vec![]);
    let pairs = [
        (10, 0),
        (11, 0),
        (12, 11),
        (13, 12),
        (1, 10),
        (3, 13),
        (20, 1),
        (21, 20),
        (22, 20),
        (11, 21),
        (12, 22),
        (23, 1),
        (24, 23),
        (2, 24),
        (31, 30),
        (32, 31),
    ];
    let mut connections: Vec<Record> = pairs.into_iter().map(|(from, to)| connect(from, to)).collect();
    for (from, to, name) in [(33, 32, axis), (32, 12, "Lcl Rotation")] {
        connections.push(Record("C", vec![Text("OP".into()), Long(from), Long(to), Text(name.into())], vec![]));
    }
    vec![
        Record("FBXHeaderExtension", vec![], vec![leaf("FBXHeaderVersion", Int(1003)), leaf("FBXVersion", Int(7400))]),
        Record("GlobalSettings", vec![], vec![leaf("Version", Int(1000)), properties(settings)]),
        Record("Objects", vec![], objects),
        Record("Connections", vec![], connections),
    ]
}

/// The file as text.
pub fn ascii(records: &[Record]) -> Vec<u8> {
    let mut text = String::from("; FBX 7.4.0 project file\n");
    records.iter().for_each(|record| write_text(&mut text, record));
    text.into_bytes()
}

fn write_text(text: &mut String, Record(name, values, children): &Record) {
    fn array<T: std::fmt::Display>(values: &[T]) -> String {
        let values: Vec<String> = values.iter().map(T::to_string).collect();
        format!("*{} {{ a: {} }}", values.len(), values.join(","))
    }
    let values = values.iter().map(|value| match value {
        Long(value) => value.to_string(),
        Int(value) => value.to_string(),
        Double(value) => value.to_string(),
        Text(value) => format!("\"{value}\""),
        Name(name, class) => format!("\"{class}::{name}\""),
        Ints(values) => array(values),
        Longs(values) => array(values),
        Doubles(values) => array(values),
        Floats(values) => array(values),
        Bytes(_) => unreachable!("a text has no bytes"),
    });
    write!(text, "{name}: {}", values.collect::<Vec<_>>().join(", ")).unwrap();
    if children.is_empty() && !matches!(*name, "Objects" | "AnimationLayer") {
        text.push('\n');
        return;
    }
    text.push_str(" {\n");
    children.iter().for_each(|child| write_text(text, child));
    text.push_str("}\n");
}

/// The file as bytes.
pub fn binary(records: &[Record]) -> Vec<u8> {
    let mut bytes = b"Kaydara FBX Binary  \0\x1a\0".to_vec();
    bytes.extend(7400_u32.to_le_bytes());
    records.iter().for_each(|record| write_bytes(&mut bytes, record));
    bytes.extend([0; 13]);
    bytes
}

fn write_bytes(bytes: &mut Vec<u8>, Record(name, values, children): &Record) {
    let start = bytes.len();
    bytes.extend([0; 12]);
    bytes.push(name.len() as u8);
    bytes.extend(name.as_bytes());
    let first = bytes.len();
    let array = |code: u8, count: usize, contents: Vec<u8>| {
        let head = [count as u32, 0, contents.len() as u32].map(u32::to_le_bytes).concat();
        [vec![code], head, contents].concat()
    };
    let text = |text: Vec<u8>| [vec![b'S'], (text.len() as u32).to_le_bytes().to_vec(), text].concat();
    for value in values {
        bytes.extend(match value {
            Long(value) => [vec![b'L'], value.to_le_bytes().to_vec()].concat(),
            Int(value) => [vec![b'I'], value.to_le_bytes().to_vec()].concat(),
            Double(value) => [vec![b'D'], value.to_le_bytes().to_vec()].concat(),
            Text(value) => text(value.as_bytes().to_vec()),
            Name(name, class) => text([name.as_bytes(), b"\0\x01", class.as_bytes()].concat()),
            Ints(values) => array(b'i', values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Longs(values) => array(b'l', values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Doubles(values) => array(b'd', values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Floats(values) => array(b'f', values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Bytes(bytes) => [vec![b'R'], (bytes.len() as u32).to_le_bytes().to_vec(), bytes.clone()].concat(),
        });
    }
    let length = bytes.len() - first;
    if !children.is_empty() {
        children.iter().for_each(|child| write_bytes(bytes, child));
        bytes.extend([0; 13]);
    }
    let end = bytes.len();
    let head = [end as u32, values.len() as u32, length as u32].map(u32::to_le_bytes).concat();
    bytes[start..start + 12].copy_from_slice(&head);
}
