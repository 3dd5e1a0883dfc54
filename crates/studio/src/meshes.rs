//! The two meshes at rest, as markers and pages need them.

use std::sync::{Arc, OnceLock};

use mimesh_core::{
    mesh::{Components, Mesh, Surface},
    spatial::{EdgePaths, UpAxis},
};
use mimesh_markers::{MarkerMesh, MeshReference, MeshRole};
use mimesh_pipeline::input::RestMesh;
use nalgebra::Vector3;
use serde::Serialize;
use serde_json::json;

use crate::container::{self, Numbers};

/// The two meshes at rest.
#[derive(Debug)]
pub struct Meshes {
    /// Source and target.
    pub sides: [Arc<RestMesh>; 2],
    /// The middles of their boxes, to which positions are relative that pages get.
    pub origins: [Vector3<f64>; 2],
    references: OnceLock<[MeshReference; 2]>,
    target_paths: OnceLock<EdgePaths>,
}

/// What a page shows of a mesh in words and numbers.
#[derive(Clone, Debug, Serialize)]
pub struct MeshFacts {
    file: Option<String>,
    vertices: usize,
    polygons: usize,
    triangles: usize,
    components: Vec<ComponentFacts>,
    bounds: [[f64; 3]; 2],
    origin: [f64; 3],
    diagonal: f64,
    up: UpAxis,
    unit: Option<String>,
    warnings: Vec<String>,
}

#[derive(Clone, Debug, Serialize)]
struct ComponentFacts {
    name: String,
    vertices: usize,
    triangles: usize,
}

/// No component, and no welded vertex.
const NONE: u32 = u32::MAX;

impl Meshes {
    /// The meshes.
    pub fn new(source: Arc<RestMesh>, target: Arc<RestMesh>) -> Self {
        let sides = [source, target];
        let origins = [0, 1].map(|k: usize| {
            let rest = &sides[k].sequence.rest;
            let (low, high) = rest.bounding_box_of(&rest.positions);
            0.5 * (low.coords + high.coords)
        });
        Self { sides, origins, references: OnceLock::new(), target_paths: OnceLock::new() }
    }

    /// Whether points of markers on these meshes are points on `other` too: both rest alike, with the same triangles.
    pub fn are_like(&self, other: &Self) -> bool {
        self.for_markers().into_iter().zip(other.for_markers()).all(|(a, b)| {
            a.mesh.positions == b.mesh.positions
                && a.surface.triangles == b.surface.triangles
                && a.surface.vertex_of == b.surface.vertex_of
        })
    }

    /// The meshes that points of markers lie on.
    pub fn for_markers(&self) -> [MarkerMesh<'_>; 2] {
        MeshRole::BOTH.map(|role| self.sides[role.index()].as_in_file(role))
    }

    /// How a file of markers names the meshes; their files are hashed once.
    pub fn references(&self) -> &[MeshReference; 2] {
        self.references.get_or_init(|| {
            let meshes = self.for_markers();
            [0, 1].map(|k: usize| MeshReference::new(self.sides[k].path.as_deref(), meshes[k]))
        })
    }

    /// Paths over the surface of the target at rest.
    pub fn target_paths(&self) -> &EdgePaths {
        self.target_paths.get_or_init(|| {
            let surface = self.for_markers()[1].surface;
            EdgePaths::new(&surface.positions, &surface.triangles, &[])
        })
    }

    /// What a page shows of side `k`; `up` and `unit` are those of its file, as far as they are known.
    pub fn facts(&self, k: usize, up: Option<UpAxis>, unit: Option<String>) -> MeshFacts {
        let side = &self.sides[k];
        let rest = &side.sequence.rest;
        let (low, high) = rest.bounding_box_of(&rest.positions);
        MeshFacts {
            file: side.path.as_ref().map(|path| path.display().to_string()),
            vertices: rest.positions.len(),
            polygons: rest.polygons.len(),
            triangles: side.surface.triangle_count(),
            components: components(&side.surface),
            bounds: [low.into(), high.into()],
            origin: self.origins[k].into(),
            diagonal: (high - low).norm(),
            up: up.unwrap_or_default(),
            unit,
            warnings: side.sequence.warnings.clone(),
        }
    }

    /// The mesh of side `k` as a container.
    pub fn container(&self, k: usize, project: u64) -> Vec<u8> {
        let side = &self.sides[k];
        let (mesh, surface) = (&side.sequence.rest, &side.surface);
        let positions = container::relative(&mesh.positions, self.origins[k]);
        let triangles: Vec<u32> = outward_triangles(mesh, surface).into_iter().flatten().collect();
        let of_vertex = surface.components().of_vertex;
        let component = |t: &[u32; 3]| of_vertex.get(t[0] as usize).copied().flatten().unwrap_or(NONE);
        let components: Vec<u32> = surface.triangles.iter().map(component).collect();
        let welded: Vec<u32> = surface.vertex_of.iter().map(|vertex| vertex.unwrap_or(NONE)).collect();
        let edges = polygon_edges(mesh);
        let header = json!({ "project": project, "side": MeshRole::BOTH[k].name() });
        let arrays = [
            ("positions", Numbers::F32(&positions)),
            ("triangles", Numbers::U32(&triangles)),
            ("components", Numbers::U32(&components)),
            ("welded", Numbers::U32(&welded)),
            ("edges", Numbers::U32(&edges)),
        ];
        container::write(header, &arrays)
    }

    /// Positions of all vertices of the file of side `k`, for those of its surface.
    pub fn to_file(&self, k: usize, on_surface: &[nalgebra::Point3<f64>]) -> Vec<nalgebra::Point3<f64>> {
        let side = &self.sides[k];
        let rest = &side.sequence.rest.positions;
        side.surface.to_mesh(on_surface).unwrap_or_else(|_| rest.clone())
    }
}

/// The triangles over the vertices of the file, their corners in the order of those of the surface.
fn outward_triangles(mesh: &Mesh, surface: &Surface) -> Vec<[u32; 3]> {
    let (mut fans, _) = mesh.polygons.fans();
    for (fan, corners) in fans.iter_mut().zip(&surface.triangles) {
        let welded = fan.map(|vertex| surface.vertex_of.get(vertex as usize).copied().flatten());
        if welded != corners.map(Some) {
            fan.swap(1, 2);
        }
    }
    fans
}

/// The edges of polygons, each once.
fn polygon_edges(mesh: &Mesh) -> Vec<u32> {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(mesh.polygons.corner_count());
    for corners in mesh.polygons.iter() {
        let around = corners.iter().zip(corners.iter().cycle().skip(1));
        edges.extend(around.map(|(&a, &b)| [a.min(b), a.max(b)]));
    }
    edges.sort_unstable();
    edges.dedup();
    edges.into_flattened()
}

/// Names and sizes of the components; a part's name if it has one, with a number where several have it.
fn components(surface: &Surface) -> Vec<ComponentFacts> {
    let Components { of_vertex, sizes } = surface.components();
    let mut triangles = vec![0; sizes.len()];
    let mut part: Vec<Option<u32>> = vec![None; sizes.len()];
    for (t, corners) in surface.triangles.iter().enumerate() {
        let Some(component) = of_vertex[corners[0] as usize] else { continue };
        triangles[component as usize] += 1;
        part[component as usize] = part[component as usize].or(surface.part_of.get(t).copied());
    }
    let name =
        |c: usize| part[c].and_then(|p| surface.part_names.get(p as usize)).cloned().unwrap_or_else(|| "part".into());
    let mut count = std::collections::HashMap::new();
    (0..sizes.len()).for_each(|c| *count.entry(name(c)).or_insert(0) += 1);
    let mut used = std::collections::HashMap::new();
    let unique = |c: usize| {
        let name = name(c);
        let number = used.entry(name.clone()).or_insert(0);
        *number += 1;
        if count[&name] == 1 { name } else { format!("{name} {number}") }
    };
    let names: Vec<String> = (0..sizes.len()).map(unique).collect();
    let facts = names.into_iter().enumerate();
    facts.map(|(c, name)| ComponentFacts { name, vertices: sizes[c], triangles: triangles[c] }).collect()
}

impl Meshes {
    /// The unique names of the components of side `k`.
    pub fn component_names(&self, k: usize) -> Vec<String> {
        components(&self.sides[k].surface).into_iter().map(|component| component.name).collect()
    }

    /// 1 for each vertex of the file of side `k` that belongs to one of the components `named`, else 0.
    pub fn weights_of_components(&self, k: usize, named: &[String]) -> Vec<f32> {
        let surface = &self.sides[k].surface;
        let names = self.component_names(k);
        let of_vertex = surface.components().of_vertex;
        let is_in = |vertex: &Option<u32>| {
            let component = vertex.and_then(|v| of_vertex[v as usize]);
            component.is_some_and(|c| named.contains(&names[c as usize]))
        };
        surface.vertex_of.iter().map(|vertex| f32::from(u8::from(is_in(vertex)))).collect()
    }
}
