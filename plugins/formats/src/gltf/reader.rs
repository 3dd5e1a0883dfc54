use std::collections::{HashMap, HashSet};

use mimesh_core::{
    Error, Result,
    mesh::{CornerAttribute, Material, Mesh, MeshSequence, Part, Pose},
    stage::{FileInput, Selection},
};
use nalgebra::{Matrix3, Point3, Vector3};

use super::{
    accessor::{indices, numbers},
    animations,
    container::Asset,
    primitive::triangles,
    scene::{self, Placed},
    schema::{self, Primitive, get},
};

/// Reads the meshes of the default scene as one, and their morph targets as poses.
///
/// # Errors
///
/// The errors of [`Asset::read`], and [`Error::File`] that names the mesh, node or accessor that cannot be read.
pub fn read(input: &dyn FileInput, _selection: &Selection) -> Result<MeshSequence> {
    let path = input.path();
    let asset = Asset::read(input)?;
    let damaged = |message: String| Error::file(path, message, "the file is damaged: export it again");
    let mut reader = Reader::new(&asset);
    for placed in scene::placed(&asset.root).map_err(damaged)? {
        reader.add(&placed).map_err(damaged)?;
    }
    let mut sequence = reader.finish();
    sequence.animations = animations::list(&asset);
    match sequence.rest.validate() {
        Err(Error::Data { message, hint }) => Err(Error::file(path, message, hint)),
        Err(other) => Err(other),
        Ok(()) => Ok(sequence),
    }
}

/// The mesh in the making.
struct Reader<'a> {
    asset: &'a Asset,
    mesh: Mesh,
    textures: CornerAttribute<[f64; 2]>,
    normals: CornerAttribute<[f64; 3]>,
    /// Where texture coordinates of an accessor start in `textures`.
    texture_starts: HashMap<usize, u32>,
    targets: Vec<MorphTarget>,
    materials_used: HashSet<usize>,
    skipped: usize,
    skinned: Vec<String>,
    weighted: Vec<String>,
}

/// One morph target, over all meshes that have one of the name.
struct MorphTarget {
    name: String,
    /// First vertex, and displacements from there on.
    moves: Vec<(usize, Vec<Vector3<f64>>)>,
}

impl<'a> Reader<'a> {
    fn new(asset: &'a Asset) -> Self {
        Self {
            asset,
            mesh: Mesh::default(),
            textures: CornerAttribute::default(),
            normals: CornerAttribute::default(),
            texture_starts: HashMap::new(),
            targets: Vec::new(),
            materials_used: HashSet::new(),
            skipped: 0,
            skinned: Vec::new(),
            weighted: Vec::new(),
        }
    }

    /// Adds the mesh of a node.
    fn add(&mut self, placed: &Placed) -> Result<(), String> {
        let mesh = get(&self.asset.root.meshes, placed.mesh, "mesh")?;
        let name = placed.node.name.as_ref().or(mesh.name.as_ref()).filter(|name| !name.is_empty());
        let name = name.cloned().unwrap_or_else(|| format!("mesh-{}", placed.mesh));
        if placed.node.skin.is_some() {
            self.skinned.push(name.clone());
        }
        if mesh.weights.iter().any(|&weight| weight != 0.0) {
            self.weighted.push(name.clone());
        }
        let names = target_names(mesh);
        // Primitives that share accessors share vertices.
        let mut vertex_starts = HashMap::new();
        let mut normal_starts = HashMap::new();
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let added = self.add_primitive(placed, &name, &names, primitive, &mut vertex_starts, &mut normal_starts);
            added.map_err(|message| format!("mesh `{name}`, primitive {index}: {message}"))?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        placed: &Placed,
        name: &str,
        target_names: &[String],
        primitive: &Primitive,
        vertex_starts: &mut HashMap<(usize, Vec<Option<usize>>), usize>,
        normal_starts: &mut HashMap<usize, u32>,
    ) -> Result<(), String> {
        let mode = primitive.mode.unwrap_or(4);
        if matches!(mode, 0..=3) {
            self.skipped += 1;
            return Ok(());
        }
        let position = primitive.attributes.position.ok_or("no positions")?;
        let count = get(&self.asset.root.accessors, position, "accessor")?.count;
        let corners = match primitive.indices {
            Some(accessor) => indices(self.asset, accessor)?,
            None => (0..u32::try_from(count).map_err(|_| format!("{count} vertices are too many"))?).collect(),
        };
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
            return Err(format!("vertex index {corner} is out of range: there are {count} vertices (from 0)"));
        }

        let key = (position, primitive.targets.iter().map(|target| target.position).collect());
        let first = match vertex_starts.get(&key) {
            Some(&first) => first,
            None => {
                let first = self.add_vertices(placed, target_names, primitive, position)?;
                *vertex_starts.entry(key).or_insert(first)
            }
        };
        let texture = match primitive.attributes.texture {
            Some(accessor) => Some(self.add_textures(accessor, count)?),
            None => None,
        };
        let normal = match primitive.attributes.normal {
            Some(accessor) => Some(self.add_normals(placed, accessor, count, normal_starts)?),
            None => None,
        };

        let linear = placed.scene_from_mesh.fixed_view::<3, 3>(0, 0);
        let mirrored = linear.determinant() < 0.0;
        let start = self.mesh.polygons.len();
        for mut triangle in triangles(mode, &corners)? {
            if mirrored {
                triangle.swap(1, 2);
            }
            self.mesh.polygons.push(&triangle.map(|v| first as u32 + v));
            self.textures.indices.extend(triangle.map(|v| texture.map(|first| first + v)));
            self.normals.indices.extend(triangle.map(|v| normal.map(|first| first + v)));
        }
        let material = match primitive.material {
            Some(material) => {
                self.materials_used.insert(material);
                Some(material_name(&self.asset.root.materials, material)?)
            }
            None => None,
        };
        self.add_part(Part {
            object: Some(name.into()),
            material,
            polygons: start..self.mesh.polygons.len(),
            ..Part::default()
        });
        Ok(())
    }

    /// Adds vertices and the morph targets that move them; the first vertex.
    fn add_vertices(
        &mut self,
        placed: &Placed,
        names: &[String],
        primitive: &Primitive,
        accessor: usize,
    ) -> Result<usize, String> {
        let first = self.mesh.positions.len();
        let positions = numbers::<3>(self.asset, accessor)?;
        if first + positions.len() > u32::MAX as usize {
            return Err("there are more than 2^32 vertices".into());
        }
        let place = |p: &[f64; 3]| Point3::from_homogeneous(placed.scene_from_mesh * Point3::from(*p).to_homogeneous());
        let placed_positions = positions.iter().map(|p| place(p).unwrap_or(Point3::new(f64::NAN, f64::NAN, f64::NAN)));
        self.mesh.positions.extend(placed_positions);
        let linear: Matrix3<f64> = placed.scene_from_mesh.fixed_view::<3, 3>(0, 0).into();
        for (target, name) in primitive.targets.iter().zip(names) {
            let Some(accessor) = target.position else { continue };
            let moves = numbers::<3>(self.asset, accessor)?;
            if moves.len() != positions.len() {
                return Err(format!(
                    "morph target `{name}` has {} vertices, the mesh {}",
                    moves.len(),
                    positions.len()
                ));
            }
            if moves.iter().flatten().any(|x| !x.is_finite()) {
                return Err(format!("morph target `{name}` has coordinates that are not finite"));
            }
            let moves = moves.into_iter().map(|d| linear * Vector3::from(d)).collect();
            self.target(name).moves.push((first, moves));
        }
        Ok(first)
    }

    /// The morph target `name`, which may have been begun by another mesh.
    fn target(&mut self, name: &str) -> &mut MorphTarget {
        let known = self.targets.iter().position(|target| target.name == name);
        let index = known.unwrap_or_else(|| {
            self.targets.push(MorphTarget { name: name.into(), moves: Vec::new() });
            self.targets.len() - 1
        });
        &mut self.targets[index]
    }

    /// Texture coordinates with their origin at the lower left, as everywhere in this program; the first.
    fn add_textures(&mut self, accessor: usize, count: usize) -> Result<u32, String> {
        if let Some(&first) = self.texture_starts.get(&accessor) {
            return Ok(first);
        }
        let values = numbers::<2>(self.asset, accessor)?;
        check_count("texture coordinates", values.len(), count)?;
        let first = self.textures.values.len() as u32;
        self.textures.values.extend(values.into_iter().map(|[u, v]| finite([u, 1.0 - v])));
        self.texture_starts.insert(accessor, first);
        Ok(first)
    }

    /// Normals in the scene, of unit length; the first.
    fn add_normals(
        &mut self,
        placed: &Placed,
        accessor: usize,
        count: usize,
        starts: &mut HashMap<usize, u32>,
    ) -> Result<u32, String> {
        if let Some(&first) = starts.get(&accessor) {
            return Ok(first);
        }
        let values = numbers::<3>(self.asset, accessor)?;
        check_count("normals", values.len(), count)?;
        let linear: Matrix3<f64> = placed.scene_from_mesh.fixed_view::<3, 3>(0, 0).into();
        let turn = linear.try_inverse().unwrap_or_else(Matrix3::identity).transpose();
        let first = self.normals.values.len() as u32;
        let placed_normal = |n: [f64; 3]| {
            let n =
                if linear == Matrix3::identity() { Vector3::from(n) } else { (turn * Vector3::from(n)).normalize() };
            finite(n.into())
        };
        self.normals.values.extend(values.into_iter().map(placed_normal));
        starts.insert(accessor, first);
        Ok(first)
    }

    /// Adds a part, or lengthens the last one if it has the same names.
    fn add_part(&mut self, part: Part) {
        match self.mesh.parts.last_mut() {
            Some(last) if (&last.object, &last.material) == (&part.object, &part.material) => {
                last.polygons.end = part.polygons.end;
            }
            _ => self.mesh.parts.push(part),
        }
    }

    fn finish(mut self) -> MeshSequence {
        let has = |indices: &[Option<u32>]| indices.iter().any(Option::is_some);
        self.mesh.texture_coordinates = has(&self.textures.indices).then_some(self.textures);
        self.mesh.normals = has(&self.normals.indices).then_some(self.normals);
        let materials = &self.asset.root.materials;
        let known = materials.iter().enumerate().filter(|(index, _)| self.materials_used.contains(index));
        self.mesh.materials = known
            .map(|(index, material)| Material {
                name: material_name(materials, index).unwrap_or_default(),
                base_color: finite(material.pbr_metallic_roughness.base_color_factor.unwrap_or([1.0; 4])),
            })
            .collect();
        let rest = &self.mesh.positions;
        let pose = |target: MorphTarget| {
            let mut positions = rest.clone();
            for (first, moves) in target.moves {
                positions[first..].iter_mut().zip(moves).for_each(|(position, displacement)| *position += displacement);
            }
            Pose::new(target.name, positions)
        };
        let poses = self.targets.into_iter().map(pose).collect();
        let mut warnings = Vec::new();
        let list = |names: &[String]| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        if !self.skinned.is_empty() {
            let names = list(&self.skinned);
            warnings.push(format!("skinned meshes were read in their bind pose, and no skeleton moves them: {names}"));
        }
        if !self.weighted.is_empty() {
            let names = list(&self.weighted);
            warnings.push(format!("the rest pose has all morph targets at 0, unlike the file's default: {names}"));
        }
        if self.skipped > 0 {
            warnings.push(format!("{} primitives of points or lines were left out", self.skipped));
        }
        MeshSequence { rest: self.mesh, poses, warnings, ..MeshSequence::default() }
    }
}

fn check_count(what: &str, found: usize, expected: usize) -> Result<(), String> {
    if found == expected { Ok(()) } else { Err(format!("{found} {what} for {expected} vertices")) }
}

/// Exporters do write NaN for what they cannot compute; no stage depends on these.
fn finite<const N: usize>(values: [f64; N]) -> [f64; N] {
    if values.iter().all(|x| x.is_finite()) { values } else { [0.0; N] }
}

/// The names of a mesh's morph targets: by convention in `extras`, else numbers; made unique by their number.
fn target_names(mesh: &schema::Mesh) -> Vec<String> {
    let given = mesh.extras.get("targetNames").and_then(|names| names.as_array());
    let count = mesh.primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0);
    let mut names: Vec<String> = Vec::new();
    for index in 0..count {
        let name = given.and_then(|names| names.get(index)?.as_str()).filter(|name| !name.is_empty());
        let mut name = name.map_or_else(|| format!("target-{index}"), str::to_owned);
        if names.contains(&name) {
            name = format!("{name}-{index}");
        }
        names.push(name);
    }
    names
}

/// The name of a material, or its number; a name that an earlier material has is told apart by the number.
fn material_name(materials: &[schema::Material], index: usize) -> Result<String, String> {
    let name = get(materials, index, "material")?.name.as_deref().filter(|name| !name.is_empty());
    let taken = |name| materials[..index].iter().any(|earlier| earlier.name.as_deref() == Some(name));
    Ok(match name {
        None => format!("material-{index}"),
        Some(name) if taken(name) => format!("{name}-{index}"),
        Some(name) => name.into(),
    })
}
