use std::io;

use mimesh_core::{
    Error,
    mesh::{ClipTime, Mesh, PosesAre, check_finite},
    stage::{SequenceWriter, WriteError},
};
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

use super::{
    binary::Binary,
    materials::{self, Materials},
    offset::offset,
    options::Options,
    output::Output,
    plan::{Object, Plan, Vertex},
    pose_clips::{PoseClip, PoseList},
    room,
};
use crate::{lost, single};

/// A glTF in the making: the rest mesh is in it, poses are added.
pub struct Writer {
    options: Options,
    mesh: Mesh,
    plan: Plan,
    output: Output,
    binary: Binary,
    rest: Vec<RestObject>,
    poses: PoseList,
    /// The most poses that will be added.
    most: usize,
    /// The place in the mesh's space that is the origin of the stored positions.
    offset: Vector3<f64>,
    warnings: Vec<String>,
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
    /// Starts with the rest mesh; at most `most` poses follow.
    ///
    /// # Errors
    ///
    /// If the mesh is empty or too large for f32, or the file cannot be written.
    pub fn new(
        options: Options,
        mesh: &Mesh,
        most: usize,
        output: Output,
        mut binary: Binary,
    ) -> Result<Self, WriteError> {
        check_size(&mesh.positions)?;
        single::check_textures(mesh, "glTF")?;
        let plan = Plan::new(mesh);
        if plan.objects.is_empty() {
            return Err(Error::data("empty mesh: no polygon has three corners", "write a mesh with triangles").into());
        }
        let offset = offset(mesh);
        let rest = plan.objects.iter().map(|object| RestObject::new(object, mesh, offset, &plan, &mut binary));
        let rest = rest.collect::<io::Result<_>>()?;
        use lost::Content::{
            MaterialColors, Materials, Normals, Objects, Polygons, TextureCoordinates, Textures, VertexColors,
        };
        let kept = [Polygons, TextureCoordinates, Normals, VertexColors, Objects, Materials, MaterialColors, Textures];
        let mut warnings = materials::warnings(mesh);
        warnings.extend(lost::sentence("glTF", mesh, &kept));
        // The document of a reader may be as large as its file and says nothing here.
        let mesh = Mesh { document: Default::default(), ..mesh.clone() };
        Ok(Self { options, mesh, plan, output, binary, rest, poses: PoseList::default(), most, offset, warnings })
    }

    fn json(&mut self) -> io::Result<Value> {
        let animations = self.animations()?;
        let materials = Materials::new(&self.plan, &self.mesh);
        let placed = self.options.node_transform(self.offset);
        let node = |i| {
            let mut node = json!({ "name": self.name(i), "mesh": i });
            let properties = placed.as_object().into_iter().flatten();
            properties.for_each(|(key, value)| node[key] = value.clone());
            node
        };
        let nodes: Vec<_> = (0..self.rest.len()).map(node).collect();
        let meshes: Vec<_> = (0..self.rest.len()).map(|i| self.mesh_json(i, &materials)).collect();
        let mut root = json!({
            "buffers": [{ "byteLength": self.binary.length() }],
            "asset": { "version": "2.0", "generator": concat!("mimesh ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
            "nodes": nodes,
            "meshes": meshes,
        });
        if !materials.json.is_empty() {
            materials.add_images(&mut self.binary, &mut root)?;
            root["materials"] = materials.json.into();
        }
        if !animations.is_empty() {
            root["animations"] = animations.into();
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
        if !self.poses.names.is_empty() {
            json["extras"] = json!({ "targetNames": self.poses.names });
        }
        json
    }

    /// The animations that show the poses.
    fn animations(&mut self) -> io::Result<Vec<Value>> {
        let clips = self.poses.clips(self.options.animation, self.options.frames_per_second);
        let animation = |clip: PoseClip| {
            let (times, targets): (Vec<f32>, Vec<usize>) = clip.keys.into_iter().unzip();
            let input = self.binary.times(&times)?;
            let output = self.binary.weights(&targets, self.poses.names.len())?;
            let channel = |node| json!({ "sampler": 0, "target": { "node": node, "path": "weights" } });
            Ok(json!({
                "name": clip.name,
                "samplers": [{ "input": input, "interpolation": "LINEAR", "output": output }],
                "channels": (0..self.rest.len()).map(channel).collect::<Vec<_>>(),
            }))
        };
        clips.into_iter().map(animation).collect()
    }
}

impl SequenceWriter for Writer {
    fn add(&mut self, name: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", self.mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        check_size(positions)?;
        let normals = self.options.pose_normals.then(|| self.plan.normals.of_groups(&self.mesh, positions));
        for (object, rest) in self.plan.objects.iter().zip(&mut self.rest) {
            let moves = object.vertices.iter().zip(&rest.positions).map(|(vertex, at)| {
                let (from, to) = (self.mesh.positions[vertex.vertex as usize], positions[vertex.vertex as usize]);
                // What has not moved stays exactly, although the file rounds where it is.
                if from == to { [0.0; 3] } else { difference((to - self.offset).into(), *at) }
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
        while self.poses.names.contains(&unique) {
            unique = format!("{name}-{}", self.poses.names.len());
        }
        self.poses.names.push(unique);
        self.poses.times.push(time.cloned());
        if !self.binary.tail.is_full() {
            return Ok(());
        }
        let known = room::Known {
            names: &self.poses.names,
            poses: self.most,
            primitives: self.plan.objects.iter().map(|object| object.primitives.len()).sum(),
            meshes: self.plan.objects.len(),
            other: 512 * self.plan.objects.len(),
        };
        Ok(room::leave(&mut self.binary, &known)?)
    }

    fn warnings(&self) -> Vec<String> {
        [self.warnings.clone(), self.poses.warnings(self.options.animation)].concat()
    }

    fn set_poses_are(&mut self, poses: PosesAre) {
        self.poses.are = Some(poses);
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        let json = self.json()?;
        self.output.finish(json, self.binary)
    }
}

impl RestObject {
    fn new(object: &Object, mesh: &Mesh, offset: Vector3<f64>, plan: &Plan, binary: &mut Binary) -> io::Result<Self> {
        let vertices = &object.vertices;
        let stored = |v: &Vertex| (mesh.positions[v.vertex as usize].coords - offset).map(|x| x as f32).into();
        let positions = vertices.iter().map(stored);
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
        if let Some(colors) = mesh.vertex_colors.as_ref().filter(|colors| colors.len() == mesh.positions.len()) {
            let values: Vec<_> = vertices.iter().map(|v| linear(colors[v.vertex as usize])).collect();
            attributes["COLOR_0"] = binary.attribute(&values, false)?.into();
        }
        let indices = object.primitives.iter().map(|p| binary.indices(&p.indices, vertices.len()));
        let indices = indices.collect::<io::Result<_>>()?;
        Ok(Self { positions, normals, attributes, indices, targets: Vec::new() })
    }
}

/// An sRGB colour as glTF holds it: linear, with the opacity as it is.
fn linear([r, g, b, opacity]: [f64; 4]) -> [f32; 4] {
    let part = |x: f64| if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    [part(r), part(g), part(b), opacity].map(|x| x as f32)
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
    single::check_positions(positions, f64::from(f32::MAX) / 4.0, "glTF")
}
