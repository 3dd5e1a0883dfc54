//! Runs of vertices and pieces of surface out of placed meshes.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use gltf::json::{
    Accessor, Index,
    mesh::{Primitive, Semantic},
};
use mimesh_core::mesh::{Mesh, Part};
use nalgebra::{Matrix4, Point3};

use super::{
    accessor::{count, has_data, numbers, whole},
    asset::{Asset, get},
    attributes::{Colors, Normals, Textures},
    evaluator::Run,
    materials,
    morphs::{self, Moves, Name, Shapes},
    primitive::{attribute, triangles},
    scene::Placed,
    skin::{Influences, Skin},
};
use crate::{gltf::document::Transforms, names::shown};

/// Files with more vertices are refused: a small file that shows one mesh under many nodes must not ask for all memory.
const MAX_VERTICES: usize = 1 << 26;

/// More vertices than this need data of their own: without it they lie at 0 but for those that sparse entries move.
const MAX_PLACELESS: usize = 1 << 16;

/// The triangles of a primitive under a node.
#[derive(Debug)]
pub struct Piece {
    /// The run of its vertices.
    pub run: usize,
    /// The primitive, by its number in the mesh.
    pub primitive: usize,
    /// The name of the object.
    object: String,
    /// The first vertex, and their number.
    vertices: (usize, usize),
    /// Corners from the first vertex of the run.
    triangles: Vec<[u32; 3]>,
    texture: Option<Index<Accessor>>,
    color: Option<Index<Accessor>>,
    normal: Option<Index<Accessor>>,
    material: Option<usize>,
}

/// The accessors that primitives must share to share vertices.
#[derive(Eq, Hash, PartialEq)]
struct Sharing {
    position: usize,
    targets: Vec<Option<usize>>,
    joints: Vec<[Option<usize>; 2]>,
}

/// The mesh in the making.
pub struct Builder<'a> {
    asset: &'a Asset,
    /// The vertices.
    pub runs: Vec<Run>,
    /// The triangles.
    pub pieces: Vec<Piece>,
    /// Poses that morph targets make.
    pub shapes: Shapes,
    skins: HashMap<usize, Arc<Skin>>,
    /// The displacements of accessors, which targets may share.
    moves: HashMap<usize, Arc<Moves>>,
}

impl<'a> Builder<'a> {
    /// Nothing yet.
    pub fn new(asset: &'a Asset) -> Self {
        let (runs, pieces, shapes, skins, moves) = Default::default();
        Self { asset, runs, pieces, shapes, skins, moves }
    }

    /// Adds the mesh of a node.
    ///
    /// # Errors
    ///
    /// Names mesh and primitive, and what cannot be read.
    pub fn add(&mut self, placed: &Placed) -> Result<(), String> {
        let mesh = get(&self.asset.root.meshes, placed.mesh, "mesh")?;
        let names = morphs::names(self.asset, placed.mesh, mesh);
        let mut shared = HashMap::new();
        for &index in &placed.primitives {
            let added = self.add_primitive(placed, index, &names, &mut shared);
            added.map_err(|message| format!("mesh `{}`, primitive {index}: {message}", shown(&placed.name)))?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        placed: &Placed,
        index: usize,
        names: &[Name],
        shared: &mut HashMap<Sharing, usize>,
    ) -> Result<(), String> {
        let primitive = &self.asset.root.meshes[placed.mesh].primitives[index];
        let position = attribute(primitive, Semantic::Positions).ok_or("no positions")?;
        let count = count(self.asset, position)?;
        // Vertices come first: that there are so many is known only when they are read.
        let sharing = Sharing::new(primitive, position);
        let run = match shared.get(&sharing) {
            Some(&run) => run,
            None => {
                let run = self.add_run(placed, primitive, position, names)?;
                *shared.entry(sharing).or_insert(run)
            }
        };
        let corners = match primitive.indices {
            Some(accessor) => whole::<1>(self.asset, accessor)?.into_flattened(),
            None => (0..u32::try_from(count).map_err(|_| format!("{count} vertices are too many"))?).collect(),
        };
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
            return Err(format!("vertex index {corner} is out of range: there are {count} vertices (from 0)"));
        }
        // Strips have about as many triangles as corners.
        self.asset.take(3 * corners.len())?;
        let triangles = triangles(&primitive.mode, &corners)?;
        if let Some(material) = primitive.material {
            get(&self.asset.root.materials, material.value(), "material")?;
        }
        self.pieces.push(Piece {
            run,
            primitive: index,
            object: placed.name.clone(),
            vertices: (self.runs[run].vertices.start, count),
            triangles,
            texture: attribute(primitive, Semantic::TexCoords(0)),
            color: attribute(primitive, Semantic::Colors(0)),
            normal: attribute(primitive, Semantic::Normals),
            material: primitive.material.map(|material| material.value()),
        });
        Ok(())
    }

    /// Adds vertices and what moves them.
    fn add_run(
        &mut self,
        placed: &Placed,
        primitive: &Primitive,
        position: Index<Accessor>,
        names: &[Name],
    ) -> Result<usize, String> {
        let asset = self.asset;
        let first = self.runs.last().map_or(0, |run| run.vertices.end);
        let added = count(asset, position)?;
        if added > MAX_VERTICES - first {
            return Err(format!("there are more than {MAX_VERTICES} vertices; choose some meshes with `meshes`"));
        }
        if added > MAX_PLACELESS && !has_data(asset, position) {
            return Err(format!("{added} positions have no data"));
        }
        let stored: Vec<Point3<f64>> = numbers::<3>(asset, position)?.into_iter().map(Point3::from).collect();
        check_finite("positions", stored.iter().map(|position| position.coords.into()))?;
        let run = self.runs.len();
        let mut targets = Vec::new();
        let still = Arc::new(Moves::default());
        for (number, target) in primitive.targets.iter().flatten().enumerate() {
            let mut moves = still.clone();
            if let Some(accessor) = target.positions {
                let entries = count(asset, accessor)?;
                if entries != stored.len() {
                    return Err(format!("morph target {number} has {entries} vertices, the mesh {}", stored.len()));
                }
                let known = self.moves.get(&accessor.value()).cloned();
                moves = match known {
                    Some(known) => known,
                    None => {
                        let read = Moves::read(asset, accessor);
                        Arc::new(read.map_err(|message| format!("morph target {number}: {message}"))?)
                    }
                };
                self.moves.insert(accessor.value(), moves.clone());
                self.shapes.add(&names[number], run, number);
            }
            targets.push(moves);
        }
        let skin = match asset.root.nodes[placed.node].skin {
            Some(skin) => {
                let skin = self.skin(skin.value())?;
                Influences::read(asset, primitive, &skin, &stored)?.map(|influences| (skin, influences))
            }
            None => None,
        };
        let vertices = first..first + stored.len();
        self.runs.push(Run { node: placed.node, mesh: placed.mesh, vertices, stored, targets, skin });
        Ok(run)
    }

    fn skin(&mut self, index: usize) -> Result<Arc<Skin>, String> {
        if let Some(skin) = self.skins.get(&index) {
            return Ok(skin.clone());
        }
        let skin = Arc::new(Skin::new(self.asset, index)?);
        Ok(self.skins.entry(index).or_insert(skin).clone())
    }
}

impl Sharing {
    fn new(primitive: &Primitive, position: Index<Accessor>) -> Self {
        let number = |semantic| attribute(primitive, semantic).map(|accessor| accessor.value());
        let set = |set| [number(Semantic::Joints(set)), number(Semantic::Weights(set))];
        Self {
            position: position.value(),
            targets: primitive.targets.iter().flatten().map(|target| target.positions.map(|p| p.value())).collect(),
            joints: (0..).map(set).take_while(|set| *set != [None; 2]).collect(),
        }
    }
}

/// The mesh of all pieces, still without positions; `transforms` are those of the runs at rest.
///
/// Triangles of mirrored runs are turned over. Runs that are `morphed` have no normals, since the file's are of another shape.
/// Texture coordinates and normals that cannot be read are left out, which is told in `warnings`.
pub fn assemble(
    asset: &Asset,
    pieces: &[Piece],
    transforms: &[Transforms],
    morphed: &[bool],
    warnings: &mut Vec<String>,
) -> Mesh {
    let material_names = materials::names(&asset.root.materials);
    let mirrored: Vec<bool> = transforms.iter().map(is_mirrored).collect();
    let (mut mesh, mut textures, mut normals) = (Mesh::default(), Textures::default(), Normals::default());
    let mut colors = Colors::default();
    let mut unread = Vec::new();
    for piece in pieces {
        let (first, count) = piece.vertices;
        let mut triangles = piece.triangles.clone();
        if mirrored[piece.run] {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let start = mesh.polygons.len();
        triangles.iter().for_each(|triangle| mesh.polygons.push(&triangle.map(|v| first as u32 + v)));
        let texture = piece
            .texture
            .and_then(|accessor| textures.start(asset, accessor, count).map_err(|e| unread.push((piece, e))).ok());
        textures.add(texture, &triangles);
        let run = (piece.run, &transforms[piece.run]);
        let normal = piece.normal.filter(|_| !morphed[piece.run]);
        let normal = normal
            .and_then(|accessor| normals.start(asset, accessor, count, run).map_err(|e| unread.push((piece, e))).ok());
        normals.add(normal, &triangles);
        if let Some(accessor) = piece.color
            && let Err(problem) = colors.add(asset, accessor, piece.vertices)
        {
            unread.push((piece, problem));
        }
        let material = piece.material.map(|material| material_names[material].clone());
        let polygons = start..mesh.polygons.len();
        add_part(&mut mesh, Part { object: Some(piece.object.clone()), material, polygons, ..Part::default() });
    }
    if let Some((piece, message)) = unread.first() {
        let Piece { object, primitive, .. } = piece;
        let others = if unread.len() > 1 { format!(" ({} such in all)", unread.len()) } else { String::new() };
        warnings.push(format!(
            "an attribute of mesh `{}`, primitive {primitive} was left out: {message}{others}",
            shown(object)
        ));
    }
    let used: HashSet<usize> = pieces.iter().filter_map(|piece| piece.material).collect();
    mesh.materials = materials::read(asset, &used);
    mesh.texture_coordinates = textures.finish();
    mesh.normals = normals.finish();
    mesh.vertex_colors = colors.finish();
    mesh
}

/// Adds a part, or lengthens the last one if it has the same names.
fn add_part(mesh: &mut Mesh, part: Part) {
    match mesh.parts.last_mut() {
        Some(last) if (&last.object, &last.material) == (&part.object, &part.material) => {
            last.polygons.end = part.polygons.end;
        }
        _ => mesh.parts.push(part),
    }
}

/// Whether most vertices are mirrored, which turns their triangles inside out.
fn is_mirrored(transforms: &Transforms) -> bool {
    let is_mirror = |matrix: &Matrix4<f64>| matrix.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
    match transforms {
        Transforms::Uniform(matrix) => is_mirror(matrix),
        Transforms::Skinned(matrices) => {
            2 * matrices.iter().filter(|matrix| is_mirror(matrix)).count() > matrices.len()
        }
    }
}

fn check_finite(what: &str, mut values: impl Iterator<Item = [f64; 3]>) -> Result<(), String> {
    match values.position(|value| !value.iter().all(|x| x.is_finite())) {
        None => Ok(()),
        Some(vertex) => Err(format!("vertex {vertex} (from 0) has {what} that are not finite")),
    }
}
