use std::io::{self, Write};

use base64::{engine::general_purpose::STANDARD, write::EncoderWriter};
use mimesh_core::{
    Error,
    mesh::{ClipTime, Mesh, check_finite},
    stage::{SequenceWriter, WriteError},
};
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

use super::{
    binary::Binary,
    plan::{Object, Plan, Vertex},
};

/// The settings with which a glTF is written.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Poses a second.
    pub frames_per_second: f64,
    /// Whether poses have their own normals.
    pub pose_normals: bool,
    /// One binary file, or JSON with the numbers inside.
    pub binary: bool,
}

/// A glTF in the making: the rest mesh is in it, poses are added.
pub struct Writer {
    options: Options,
    mesh: Mesh,
    plan: Plan,
    binary: Binary,
    rest: Vec<RestObject>,
    names: Vec<String>,
}

/// The parts of an object that have been written.
struct RestObject {
    /// Rest positions as they stand in the file.
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    attributes: Value,
    /// The accessors of indices, one a primitive.
    indices: Vec<usize>,
    /// One a pose.
    targets: Vec<Value>,
}

impl Writer {
    /// Starts with the rest mesh.
    ///
    /// # Errors
    ///
    /// If the mesh is empty or too large for f32, or there is no room for temporary data.
    pub fn new(options: Options, mesh: &Mesh) -> Result<Self, WriteError> {
        mesh.validate()?;
        check_size(&mesh.positions)?;
        let plan = Plan::new(mesh);
        if plan.objects.is_empty() {
            return Err(Error::data("empty mesh: no polygon has three corners", "write a mesh with triangles").into());
        }
        let mut binary = Binary::new()?;
        let rest = plan.objects.iter().map(|object| RestObject::new(object, mesh, &plan, &mut binary));
        let rest = rest.collect::<io::Result<_>>()?;
        // The document of a reader may be as large as its file and says nothing here.
        let mesh = Mesh { document: Default::default(), ..mesh.clone() };
        Ok(Self { options, mesh, plan, binary, rest, names: Vec::new() })
    }

    /// The JSON, with `uri` as the place of the buffer if it is not in the same file.
    fn json(&mut self, uri: Option<&str>) -> io::Result<Value> {
        let animation = self.animation()?;
        let materials = Materials::new(self);
        let mut buffer = json!({ "byteLength": self.binary.length });
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        let nodes: Vec<_> = (0..self.rest.len()).map(|i| json!({ "name": self.name(i), "mesh": i })).collect();
        let meshes: Vec<_> = (0..self.rest.len()).map(|i| self.mesh_json(i, &materials)).collect();
        // The buffer comes first: its URI is looked for when the numbers are put in its place.
        let mut root = json!({
            "buffers": [buffer],
            "asset": { "version": "2.0", "generator": concat!("mimesh ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
            "nodes": nodes,
            "meshes": meshes,
        });
        if !materials.json.is_empty() {
            root["materials"] = materials.json.into();
        }
        if let Some(animation) = animation {
            root["animations"] = json!([animation]);
        }
        root["accessors"] = std::mem::take(&mut self.binary.accessors).into();
        root["bufferViews"] = std::mem::take(&mut self.binary.views).into();
        Ok(root)
    }

    fn name(&self, object: usize) -> &str {
        self.plan.objects[object].name.as_deref().unwrap_or("mesh")
    }

    fn mesh_json(&self, index: usize, materials: &Materials) -> Value {
        let (object, rest) = (&self.plan.objects[index], &self.rest[index]);
        let primitives = object.primitives.iter().zip(&rest.indices).map(|(primitive, indices)| {
            let mut json = json!({ "attributes": rest.attributes, "indices": indices });
            if let Some(material) = &primitive.material {
                json["material"] = materials.index(material).into();
            }
            if !rest.targets.is_empty() {
                json["targets"] = rest.targets.clone().into();
            }
            json
        });
        let mut json = json!({ "name": self.name(index), "primitives": primitives.collect::<Vec<_>>() });
        if !self.names.is_empty() {
            json["extras"] = json!({ "targetNames": self.names });
        }
        json
    }

    /// An animation that shows pose i in frame i, and fades from each to the next in between.
    fn animation(&mut self) -> io::Result<Option<Value>> {
        let frames = self.names.len();
        if frames == 0 {
            return Ok(None);
        }
        let times: Vec<f32> = (0..frames).map(|i| (i as f64 / self.options.frames_per_second) as f32).collect();
        let input = self.binary.times(&times)?;
        let output = self.binary.identity_weights(frames)?;
        let channel = |node| json!({ "sampler": 0, "target": { "node": node, "path": "weights" } });
        Ok(Some(json!({
            "name": "poses",
            "samplers": [{ "input": input, "interpolation": "LINEAR", "output": output }],
            "channels": (0..self.rest.len()).map(channel).collect::<Vec<_>>(),
        })))
    }
}

impl SequenceWriter for Writer {
    fn add(&mut self, name: &str, _time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", self.mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        check_size(positions)?;
        let normals = self.options.pose_normals.then(|| self.plan.normals.of_groups(&self.mesh, positions));
        for (object, rest) in self.plan.objects.iter().zip(&mut self.rest) {
            let moves = object.vertices.iter().zip(&rest.positions).map(|(vertex, at)| {
                let (from, to) = (self.mesh.positions[vertex.vertex as usize], positions[vertex.vertex as usize]);
                // What has not moved stays exactly, although the file rounds where it is.
                if from == to { [0.0; 3] } else { difference(to.into(), *at) }
            });
            let moves: Vec<_> = moves.collect();
            let mut target = json!({ "POSITION": self.binary.displacements(&moves, true)? });
            if let Some(normals) = &normals {
                let turns = object.vertices.iter().zip(&rest.normals).map(|(vertex, at)| {
                    let normal = vertex_normal(vertex, normals);
                    if normal.map(|x| x as f32) == *at { [0.0; 3] } else { difference(normal, *at) }
                });
                let turns: Vec<_> = turns.collect();
                target["NORMAL"] = self.binary.displacements(&turns, false)?.into();
            }
            rest.targets.push(target);
        }
        let mut unique = name.to_owned();
        while self.names.contains(&unique) {
            unique = format!("{name}-{}", self.names.len());
        }
        self.names.push(unique);
        Ok(())
    }

    fn finish(mut self: Box<Self>, out: &mut dyn Write) -> Result<(), WriteError> {
        if self.options.binary { self.finish_binary(out) } else { self.finish_text(out) }
    }
}

impl Writer {
    fn finish_binary(&mut self, out: &mut dyn Write) -> Result<(), WriteError> {
        let mut json = serde_json::to_vec(&self.json(None)?).map_err(io::Error::from)?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + json.len() as u64 + 8 + self.binary.length;
        let Ok(length) = u32::try_from(length) else {
            return Err(Error::data(
                format!("the poses make a GLB of {length} bytes, but one cannot have more than {}", u32::MAX),
                "write fewer poses to a file, turn off `pose_normals`, or write one OBJ or PLY a pose",
            )
            .into());
        };
        out.write_all(b"glTF\x02\0\0\0")?;
        out.write_all(&length.to_le_bytes())?;
        out.write_all(&(json.len() as u32).to_le_bytes())?;
        out.write_all(b"JSON")?;
        out.write_all(&json)?;
        out.write_all(&(self.binary.length as u32).to_le_bytes())?;
        out.write_all(b"BIN\0")?;
        io::copy(&mut self.binary.contents()?, out)?;
        Ok(())
    }

    fn finish_text(&mut self, out: &mut dyn Write) -> Result<(), WriteError> {
        const URI: &str = "data:application/octet-stream;base64,";
        let json = serde_json::to_string(&self.json(Some(URI))?).map_err(io::Error::from)?;
        let place = json.find(URI).expect("the URI has just been written") + URI.len();
        out.write_all(&json.as_bytes()[..place])?;
        let mut encoder = EncoderWriter::new(&mut *out, &STANDARD);
        io::copy(&mut self.binary.contents()?, &mut encoder)?;
        encoder.finish()?;
        drop(encoder);
        Ok(out.write_all(&json.as_bytes()[place..])?)
    }
}

impl RestObject {
    fn new(object: &Object, mesh: &Mesh, plan: &Plan, binary: &mut Binary) -> io::Result<Self> {
        let vertices = &object.vertices;
        let positions = vertices.iter().map(|v| mesh.positions[v.vertex as usize].coords.map(|x| x as f32).into());
        let positions: Vec<[f32; 3]> = positions.collect();
        let normals = vertices.iter().map(|v| vertex_normal(v, plan.normals.rest()).map(|x| x as f32));
        let normals: Vec<_> = normals.collect();
        let mut attributes =
            json!({ "POSITION": binary.attribute(&positions, true)?, "NORMAL": binary.attribute(&normals, false)? });
        if let Some(textures) = mesh.texture_coordinates.as_ref().filter(|_| object.textured) {
            // glTF counts from the upper left.
            let value = |v: &Vertex| v.texture.map_or([0.0; 2], |t| textures.values[t as usize]);
            let values: Vec<_> = vertices.iter().map(value).map(|[u, v]| [u as f32, (1.0 - v) as f32]).collect();
            attributes["TEXCOORD_0"] = binary.attribute(&values, false)?.into();
        }
        let indices = object.primitives.iter().map(|p| binary.indices(&p.indices, vertices.len()));
        let indices = indices.collect::<io::Result<_>>()?;
        Ok(Self { positions, normals, attributes, indices, targets: Vec::new() })
    }
}

/// The materials that primitives name.
struct Materials<'a> {
    names: Vec<&'a str>,
    json: Vec<Value>,
}

impl<'a> Materials<'a> {
    fn new(writer: &'a Writer) -> Self {
        let mut names: Vec<&str> = Vec::new();
        let primitives = writer.plan.objects.iter().flat_map(|object| &object.primitives);
        for name in primitives.filter_map(|primitive| primitive.material.as_deref()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let json = names.iter().map(|name| material(writer, name)).collect();
        Self { names, json }
    }

    fn index(&self, name: &str) -> usize {
        self.names.iter().position(|other| *other == name).expect("every material in use has an entry")
    }
}

/// A matt material; without a known colour it is white.
fn material(writer: &Writer, name: &str) -> Value {
    let known = writer.mesh.materials.iter().find(|material| material.name == name);
    let color = known.map_or([1.0; 4], |material| material.base_color.map(|x| x.clamp(0.0, 1.0)));
    let mut json = json!({
        "name": name,
        "pbrMetallicRoughness": { "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 1.0 },
    });
    if color[3] < 1.0 {
        json["alphaMode"] = "BLEND".into();
    }
    json
}

/// The unit normal of a vertex of the plan; upwards where there is none.
fn vertex_normal(vertex: &Vertex, groups: &[[f64; 3]]) -> [f64; 3] {
    let normal = vertex.normal.map_or(Vector3::z(), |group| groups[group as usize].into());
    normal.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::z).into()
}

/// The difference from the contents of the file to `to`.
fn difference(to: [f64; 3], from: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| (to[i] - f64::from(from[i])) as f32)
}

/// glTF holds f32 only, and a displacement may be twice as large as a position.
fn check_size(positions: &[Point3<f64>]) -> Result<(), Error> {
    let limit = f64::from(f32::MAX) / 4.0;
    match positions.iter().position(|p| p.coords.amax() > limit) {
        None => Ok(()),
        Some(vertex) => Err(Error::data(
            format!(
                "vertex {vertex} (from 0) has coordinate {:e}, beyond the numbers of glTF",
                positions[vertex].coords.amax()
            ),
            "scale the mesh down",
        )),
    }
}
