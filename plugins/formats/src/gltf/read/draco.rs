//! `KHR_draco_mesh_compression`: primitives whose accessors have no data of their own.

use std::collections::BTreeMap;

use draco_core::{DataType, DecodeLimits, DecoderBuffer, FaceIndex, Mesh, MeshDecoder, PointIndex};
use gltf::json::{
    Accessor, Index,
    accessor::ComponentType,
    mesh::{Primitive, Semantic},
    validation::Checked,
};
use serde_json::Value;

use super::{
    asset::{Asset, follow, size},
    views::view_bytes,
};
use crate::names::shown;

/// The name of the extension.
pub const NAME: &str = "KHR_draco_mesh_compression";

/// The contents of the accessors that only Draco's data hold, by number, for the primitives that are needed.
///
/// # Errors
///
/// Names mesh and primitive that cannot be decoded, and the extension.
pub fn unpack(asset: &Asset, is_needed: &dyn Fn(usize, usize) -> bool) -> Result<BTreeMap<usize, Vec<u8>>, String> {
    let mut unpacked = BTreeMap::new();
    let mut room = asset.room();
    for (mesh_index, mesh) in asset.root.meshes.iter().enumerate() {
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let settings = primitive.extensions.as_ref().and_then(|extensions| extensions.others.get(NAME));
            let Some(settings) = settings.filter(|_| is_needed(mesh_index, index)) else { continue };
            // Data of its own are a fallback, and exact.
            let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if position.is_none_or(|&position| has_data(asset, position)) {
                continue;
            }
            let decoded = decode(asset, primitive, settings).and_then(|decoded| {
                let size = decoded.iter().map(|(_, bytes)| bytes.len()).sum();
                let left = room.checked_sub(size);
                room = left.ok_or_else(|| format!("all primitives together are more than {} bytes", asset.room()))?;
                Ok(decoded)
            });
            unpacked.extend(decoded.map_err(|message| {
                let name = shown(mesh.name.as_deref().unwrap_or("without a name"));
                format!("mesh `{name}`, primitive {index} is compressed with {NAME} and cannot be decoded: {message}")
            })?);
        }
    }
    Ok(unpacked)
}

/// Whether an accessor has numbers of its own.
pub fn has_data(asset: &Asset, index: Index<Accessor>) -> bool {
    let accessor = asset.root.accessors.get(index.value());
    accessor.is_some_and(|accessor| accessor.buffer_view.is_some() || accessor.sparse.is_some())
}

fn decode(asset: &Asset, primitive: &Primitive, settings: &Value) -> Result<Vec<(usize, Vec<u8>)>, String> {
    let view = settings["bufferView"].as_f64().ok_or("no buffer view")? as usize;
    let bytes = view_bytes(asset, view).map_err(|message| format!("it {message}"))?;
    let indices = primitive.indices.ok_or("it has no accessor of indices")?;
    let corners = size(follow(&asset.root.accessors, indices, "accessor")?.count);
    let position = primitive.attributes[&Checked::Valid(Semantic::Positions)];
    let vertices = size(follow(&asset.root.accessors, position, "accessor")?.count);
    let limits = DecodeLimits::default();
    let limits = limits.with_max_points(limits.max_points.min(vertices as u64));
    let limits = limits.with_max_faces(limits.max_faces.min(corners as u64 / 3));
    let mut mesh = Mesh::new();
    let decoded = MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh);
    decoded.map_err(|problem| problem.to_string())?;
    if (mesh.num_points(), mesh.num_faces() * 3) != (vertices, corners) {
        return Err(format!(
            "it has {} vertices and {} corners: expected {vertices} and {corners}",
            mesh.num_points(),
            mesh.num_faces() * 3
        ));
    }
    let mut unpacked = vec![(indices.value(), corner_bytes(asset, indices, &mesh)?)];
    for (name, id) in settings["attributes"].as_object().into_iter().flatten() {
        let known = primitive.attributes.iter().find(|(semantic, _)| match semantic {
            Checked::Valid(semantic) => semantic.to_string() == *name,
            Checked::Invalid => false,
        });
        let (Some((_, &accessor)), Some(id)) = (known, id.as_f64()) else { continue };
        unpacked.push((accessor.value(), attribute_bytes(asset, accessor, &mesh, id as u32)?));
    }
    if !unpacked.iter().any(|(accessor, _)| *accessor == position.value()) {
        return Err("it has no positions".into());
    }
    Ok(unpacked)
}

fn component_type(asset: &Asset, index: Index<Accessor>) -> Result<ComponentType, String> {
    match follow(&asset.root.accessors, index, "accessor")?.component_type {
        Checked::Valid(kind) => Ok(kind.0),
        Checked::Invalid => Err(format!("accessor {index} has an unknown component type")),
    }
}

fn corner_bytes(asset: &Asset, accessor: Index<Accessor>, mesh: &Mesh) -> Result<Vec<u8>, String> {
    let kind = component_type(asset, accessor)?;
    let faces = (0..mesh.num_faces()).map(|face| mesh.face(FaceIndex(face as u32)));
    let corners = faces.flatten().map(|PointIndex(vertex)| f64::from(vertex));
    Ok(corners.flat_map(|corner| stored(corner, kind)).collect())
}

/// An attribute for all vertices in order, as its accessor stores numbers.
fn attribute_bytes(asset: &Asset, accessor: Index<Accessor>, mesh: &Mesh, id: u32) -> Result<Vec<u8>, String> {
    let kind = component_type(asset, accessor)?;
    let Checked::Valid(shape) = asset.root.accessors[accessor.value()].type_ else {
        return Err(format!("accessor {accessor} has an unknown type"));
    };
    let attribute = mesh.attribute_by_unique_id(id).ok_or_else(|| format!("it has no attribute {id}"))?;
    let components = usize::from(attribute.num_components());
    if components != shape.multiplicity() {
        return Err(format!("attribute {id} has {components} components: expected {}", shape.multiplicity()));
    }
    let (number, width) =
        reading(attribute.data_type()).ok_or_else(|| format!("attribute {id} has unknown numbers"))?;
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0).max(components * width);
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(mesh.num_points() * components * kind.size());
    for vertex in 0..mesh.num_points() {
        let entry = attribute.mapped_index(PointIndex(vertex as u32)).0 as usize;
        let start = entry.checked_mul(stride);
        let entry = start.and_then(|start| data.get(start..start.checked_add(components * width)?));
        let entry = entry.ok_or_else(|| format!("attribute {id} has no value for vertex {vertex}"))?;
        bytes.extend(entry.chunks_exact(width).flat_map(|component| stored(number(component), kind)));
    }
    Ok(bytes)
}

type Reading = fn(&[u8]) -> f64;

/// How a number of Draco is read, and its bytes.
fn reading(kind: DataType) -> Option<(Reading, usize)> {
    Some(match kind {
        DataType::Int8 => (|b| f64::from(b[0] as i8), 1),
        DataType::Uint8 | DataType::Bool => (|b| f64::from(b[0]), 1),
        DataType::Int16 => (|b| f64::from(i16::from_le_bytes([b[0], b[1]])), 2),
        DataType::Uint16 => (|b| f64::from(u16::from_le_bytes([b[0], b[1]])), 2),
        DataType::Int32 => (|b| f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4),
        DataType::Uint32 => (|b| f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4),
        DataType::Float32 => (|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4),
        _ => return None,
    })
}

/// A number in the bytes of an accessor.
fn stored(number: f64, kind: ComponentType) -> impl Iterator<Item = u8> {
    let bytes = match kind {
        ComponentType::I8 => (number as i8 as u8 as u32).to_le_bytes(),
        ComponentType::U8 => u32::from(number as u8).to_le_bytes(),
        ComponentType::I16 => u32::from(number as i16 as u16).to_le_bytes(),
        ComponentType::U16 => u32::from(number as u16).to_le_bytes(),
        ComponentType::U32 => (number as u32).to_le_bytes(),
        ComponentType::F32 => (number as f32).to_le_bytes(),
    };
    bytes.into_iter().take(kind.size())
}
