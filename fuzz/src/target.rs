//! Readers under test, by name.

use crate::{judge, others};

/// A reader under test.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name: the extension of its files, or what it reads.
    pub name: &'static str,
    /// The form of its files, by which they are mutated.
    pub form: Form,
    /// Reads bytes, and gives what came of it in words without numbers, or the promise that was broken.
    pub run: fn(&str, &[u8]) -> Result<String, String>,
    /// Words of its language.
    pub words: &'static [&'static str],
}

/// The form of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Lines of words.
    Text,
    /// Bytes, with or without text before them.
    Bytes,
    /// JSON.
    Json,
    /// The chunks of a GLB.
    Glb,
}

const GLTF_WORDS: &[&str] = &[
    "POSITION",
    "NORMAL",
    "TEXCOORD_0",
    "JOINTS_0",
    "WEIGHTS_0",
    "COLOR_0",
    "SCALAR",
    "VEC3",
    "VEC4",
    "MAT4",
    "translation",
    "rotation",
    "weights",
    "LINEAR",
    "STEP",
    "CUBICSPLINE",
    "sparse",
    "targets",
    "skin",
    "mesh",
    "children",
    "byteStride",
    "count",
    "normalized",
];

const YAML_WORDS: &[&str] = &[
    "source:",
    "target:",
    "rest:",
    "poses:",
    "output:",
    "include:",
    "variables:",
    "matrix:",
    "targets:",
    "transfer:",
    "type:",
    "${a}",
    "{pose}",
    "&a",
    "*a",
    "<<:",
    "null",
    "[",
    "]",
    "{",
    "}",
    "- ",
    "|",
    "!!str",
    "auto",
    "gradient",
    "correspondence:",
    "metrics:",
];

/// All targets.
pub fn targets() -> Vec<Target> {
    use Form::{Bytes, Glb, Json, Text};
    let mesh = |name, form, words| Target { name, form, run: judge::mesh, words };
    let points = |name, form, words| Target { name, form, run: others::points, words };
    vec![
        mesh(
            "obj",
            Text,
            &["v", "vt", "vn", "f", "o", "g", "usemtl", "mtllib", "1/2/3", "//", "\\\n", "#", "nan", "1e308"],
        ),
        mesh(
            "ply",
            Bytes,
            &[
                "element vertex ",
                "element face ",
                "property list uchar int vertex_indices",
                "end_header",
                "tristrips",
                "texcoord",
            ],
        ),
        mesh("stl", Bytes, &["solid", "endsolid", "facet normal", "outer loop", "vertex", "endloop", "endfacet"]),
        mesh("off", Text, &["OFF", "COFF", "NOFF", "STOFF", "4OFF", "BINARY", "#", "nan"]),
        mesh("glb", Glb, GLTF_WORDS),
        mesh("gltf", Json, GLTF_WORDS),
        mesh(
            "fbx",
            Bytes,
            &[
                "Objects: {",
                "Model: 1, \"Model::a\", \"Mesh\" {",
                "Connections: {",
                "C: \"OO\",1,0",
                "Vertices: *9 { a: ",
                "}",
            ],
        ),
        mesh("pc2", Bytes, &["POINTCACHE2\0"]),
        mesh("mdd", Bytes, &[]),
        points("json", Json, &["name", "position", "vertex", "triangle", "barycentric", "markups", "controlPoints"]),
        points("csv", Text, &["name,x,y,z", "vertex", "triangle,u,v", "\"", ";", "\t"]),
        points("pts", Text, &["Version 1.0", "n_points: 3", "{", "}", "9999 9999 9999"]),
        points(
            "pp",
            Text,
            &["<PickedPoints>", "<point x=\"0\" y=\"0\" z=\"0\"/>", "&amp;", "<!DOCTYPE a>", "active=\"0\""],
        ),
        points("fcsv", Text, &["# CoordinateSystem = LPS", "# columns = id,x,y,z", "\""]),
        points(
            "landmarkAscii",
            Text,
            &["# AmiraMesh 3D ASCII 2.0", "define Markers 2", "@1", "@2", "Markers { float[3] Coordinates } @1"],
        ),
        Target { name: "cons", form: Text, run: others::pairs, words: &[",", "0, 0", "-1"] },
        Target {
            name: "yaml",
            form: Text,
            run: others::pairs,
            words: &["markers:", "- {", "source:", "target:", "barycentric:", "at:", "&a", "*a"],
        },
        Target { name: "pipeline", form: Text, run: others::pipeline, words: YAML_WORDS },
        Target { name: "cache", form: Bytes, run: others::cache, words: &["null", "[", "]", "{", "}"] },
    ]
}
