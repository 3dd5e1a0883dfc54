//! Normals of posed meshes.
//!
//! A file's normals hold an artist's decision, hard edges here and smooth surface there, that positions alone do not tell.
//! So they are not computed anew but turned: corners that meet at a vertex and have one normal form a group, the polygons
//! of a group have an area-weighted normal, and as that turns from rest to pose so does the normal of the file. At rest
//! every normal is therefore the file's own, and a rigid motion turns all of them by itself.

use std::collections::HashMap;

use mimesh_core::mesh::{CornerAttribute, Mesh, Polygons, Surface};
use nalgebra::{Matrix3, Point3, Vector3};

/// The normals of a rest mesh, ready to follow its poses.
#[derive(Debug)]
pub struct PosedNormals {
    /// The group of each corner of the mesh.
    pub group_of: Vec<u32>,
    groups: Turned,
    /// Where the groups of each value of the file start in `members`; one entry more than there are values.
    starts: Vec<u32>,
    members: Vec<u32>,
    values: Turned,
}

impl PosedNormals {
    /// Groups the corners of `mesh`, at rest at `rest` (#V × 3).
    ///
    /// Corners for which the file gives no normal are smooth: all of one welded vertex form a group.
    pub fn new(mesh: &Mesh, rest: &[Point3<f64>]) -> Self {
        let welded = Surface::new(mesh).map(|surface| surface.vertex_of).unwrap_or_default();
        let place = |vertex: u32| welded.get(vertex as usize).copied().flatten().unwrap_or(vertex);
        let none = CornerAttribute::default();
        let normals = mesh.normals.as_ref().unwrap_or(&none);
        let distinct = distinct(&normals.values);

        // The groups at a place are few: a list of them, the last one first. Where they are many, the others are in a table.
        let mut last = vec![NONE; mesh.positions.len()];
        let mut listed: Vec<Listed> = Vec::new();
        let mut crowded = HashMap::new();
        let mut group_of = Vec::with_capacity(mesh.polygons.corner_count());
        let mut groups = Turned::default();
        let mut uses = Vec::new();
        for polygon in 0..mesh.polygons.len() {
            let range = mesh.polygons.corner_range(polygon);
            let corners = mesh.polygons.get(polygon);
            for (at, corner) in range.enumerate() {
                let value = normals.indices.get(corner).copied().flatten();
                // A normal without a direction, as exporters write where a face has no area, is as good as none.
                let given = value.filter(|&v| Vector3::from(normals.values[v as usize]).norm_squared() > 0.0);
                let normal = given.map(|v| distinct[v as usize]);
                let last = &mut last[place(corners[at]) as usize];
                let (mut group, mut steps) = (*last, 0);
                while group != NONE && listed[group as usize].normal != normal {
                    group = listed[group as usize].before;
                    steps += 1;
                }
                let key = (place(corners[at]), normal);
                if group == NONE && steps == MAX_LISTED {
                    group = crowded.get(&key).copied().unwrap_or(NONE);
                }
                if group == NONE {
                    group = listed.len() as u32;
                    listed.push(Listed { normal, before: *last });
                    if steps == MAX_LISTED {
                        crowded.insert(key, group);
                    } else {
                        *last = group;
                    }
                    groups.rest.push(given.map_or([0.0; 3], |v| normals.values[v as usize]));
                    groups.edges.push([corners[at], corners[(at + 1) % corners.len()]]);
                }
                group_of.push(group);
                uses.extend(value.map(|v| (v, group)));
            }
        }
        groups.areas = group_areas(&group_of, groups.rest.len(), &mesh.polygons, rest);
        groups.frames = frames(&groups.areas, &groups.edges, rest);
        // A group without a normal of the file has the one it was given here.
        for (group, _) in listed.iter().enumerate().filter(|(_, group)| group.normal.is_none()) {
            groups.rest[group] = unit(groups.areas[group]);
        }

        uses.sort_unstable();
        uses.dedup();
        let mut starts = vec![0; normals.values.len() + 1];
        uses.iter().for_each(|&(value, _)| starts[value as usize + 1] += 1);
        (1..starts.len()).for_each(|i| starts[i] += starts[i - 1]);
        let members: Vec<u32> = uses.into_iter().map(|(_, group)| group).collect();
        let mut result = Self { group_of, groups, starts, members, values: Turned::default() };
        let areas = result.value_areas(&result.groups.areas);
        let edges = (0..normals.values.len()).map(|v| match result.members_of(v).first() {
            Some(&group) => result.groups.edges[group as usize],
            None => [0, 0],
        });
        let edges: Vec<_> = edges.collect();
        result.values = Turned { rest: normals.values.clone(), frames: frames(&areas, &edges, rest), areas, edges };
        result
    }

    /// The normal of each group at rest: the file's, or the area-weighted one of unit length where it gives none.
    pub fn rest(&self) -> &[[f64; 3]] {
        &self.groups.rest
    }

    /// The normal of each group when the vertices are at `posed` (#V × 3).
    pub fn of_groups(&self, mesh: &Mesh, posed: &[Point3<f64>]) -> Vec<[f64; 3]> {
        let areas = group_areas(&self.group_of, self.groups.rest.len(), &mesh.polygons, posed);
        self.groups.turn(&areas, posed)
    }

    /// The normal of each value of the file when the vertices are at `posed` (#V × 3).
    ///
    /// A value that the corners of several vertices share turns as the sum of their groups does.
    pub fn of_values(&self, mesh: &Mesh, posed: &[Point3<f64>]) -> Vec<[f64; 3]> {
        let areas = group_areas(&self.group_of, self.groups.rest.len(), &mesh.polygons, posed);
        self.values.turn(&self.value_areas(&areas), posed)
    }

    fn members_of(&self, value: usize) -> &[u32] {
        &self.members[self.starts[value] as usize..self.starts[value + 1] as usize]
    }

    fn value_areas(&self, areas: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        (0..self.starts.len() - 1).map(|v| self.members_of(v).iter().map(|&g| areas[g as usize]).sum()).collect()
    }
}

/// So many groups at a place are in a list, which is looked through one by one.
const MAX_LISTED: usize = 16;

/// No group.
const NONE: u32 = u32::MAX;

/// A group while groups are found.
struct Listed {
    /// The normal of its corners, by the first value that is the same.
    normal: Option<u32>,
    /// The group at the same place that was found before it, or [`NONE`].
    before: u32,
}

/// Normals at rest and what tells how they turn.
#[derive(Debug, Default)]
struct Turned {
    rest: Vec<[f64; 3]>,
    /// Area normals at rest.
    areas: Vec<Vector3<f64>>,
    /// An edge beside each, which fixes the turn about the normal itself.
    edges: Vec<[u32; 2]>,
    /// Orthonormal frames at rest, where area and edge span one.
    frames: Vec<Option<Matrix3<f64>>>,
}

impl Turned {
    fn turn(&self, areas: &[Vector3<f64>], posed: &[Point3<f64>]) -> Vec<[f64; 3]> {
        let turn = |i: usize| {
            let Some(rest_frame) = &self.frames[i] else { return self.rest[i] };
            let Some(posed_frame) = frame(&areas[i], self.edges[i], posed) else { return self.rest[i] };
            if posed_frame == *rest_frame {
                return self.rest[i];
            }
            (posed_frame * (rest_frame.transpose() * Vector3::from(self.rest[i]))).into()
        };
        (0..self.rest.len()).map(turn).collect()
    }
}

/// For each value the first that has the same bits.
fn distinct(values: &[[f64; 3]]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(values.len());
    let key = |n: &[f64; 3]| n.map(|x| (x + 0.0).to_bits());
    values.iter().enumerate().map(|(v, n)| *first.entry(key(n)).or_insert(v as u32)).collect()
}

/// For each group the sum of area normals of the polygons at its corners.
fn group_areas(group_of: &[u32], groups: usize, polygons: &Polygons, positions: &[Point3<f64>]) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); groups];
    for polygon in 0..polygons.len() {
        let normal = area_normal(polygons.get(polygon), positions);
        for &group in &group_of[polygons.corner_range(polygon)] {
            sums[group as usize] += normal;
        }
    }
    sums
}

/// Twice the area of a polygon times its normal, from differences to its first corner so that a far origin costs no digits.
fn area_normal(corners: &[u32], positions: &[Point3<f64>]) -> Vector3<f64> {
    let Some((&first, others)) = corners.split_first() else { return Vector3::zeros() };
    let first = positions[first as usize];
    let edge = |v: u32| positions[v as usize] - first;
    others.windows(2).map(|pair| edge(pair[0]).cross(&edge(pair[1]))).sum()
}

fn frames(areas: &[Vector3<f64>], edges: &[[u32; 2]], positions: &[Point3<f64>]) -> Vec<Option<Matrix3<f64>>> {
    areas.iter().zip(edges).map(|(area, &edge)| frame(area, edge, positions)).collect()
}

/// An orthonormal frame with the area normal as its third column; `None` where there is no area or the edge runs along it.
fn frame(area: &Vector3<f64>, [from, to]: [u32; 2], positions: &[Point3<f64>]) -> Option<Matrix3<f64>> {
    let z = area.try_normalize(f64::MIN_POSITIVE)?;
    let edge = (positions[to as usize] - positions[from as usize]).try_normalize(f64::MIN_POSITIVE)?;
    // Nearly parallel directions leave less than half of the digits.
    let x = (edge - z * z.dot(&edge)).try_normalize(1e-8)?;
    Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
}

/// Unit length; upwards where there is no direction.
fn unit(normal: Vector3<f64>) -> [f64; 3] {
    normal.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::z).into()
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    /// A tent of two slopes, six vertices, with one normal for both along the ridge or one a slope.
    fn tent(hard: bool) -> Mesh {
        let p = Point3::new;
        let positions =
            vec![p(-1., 0., 0.), p(-1., 0., 2.), p(0., 1., 0.), p(0., 1., 2.), p(1., 0., 0.), p(1., 0., 2.)];
        let mut mesh = Mesh { positions, ..Mesh::default() };
        mesh.polygons.push(&[0, 1, 3, 2]);
        mesh.polygons.push(&[2, 3, 5, 4]);
        let left = [-0.6, 0.8, 0.0];
        let right = [0.6, 0.8, 0.0];
        let indices = if hard { [0, 0, 0, 0, 1, 1, 1, 1] } else { [0, 0, 2, 2, 2, 2, 1, 1] };
        let indices = indices.map(Some).to_vec();
        mesh.normals = Some(CornerAttribute { values: vec![left, right, [0., 1., 0.]], indices });
        mesh
    }

    #[test]
    fn normals_at_rest_are_those_of_the_file_to_the_last_bit() {
        for mesh in [tent(false), tent(true)] {
            let normals = PosedNormals::new(&mesh, &mesh.positions);
            assert_eq!(normals.of_values(&mesh, &mesh.positions), mesh.normals.as_ref().unwrap().values);
            assert_eq!(normals.of_groups(&mesh, &mesh.positions), normals.rest());
        }
    }

    #[test]
    fn a_rigid_motion_turns_every_used_normal_by_itself() {
        let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        let mesh = tent(false);
        let posed: Vec<_> = mesh.positions.iter().map(|p| turn * p + Vector3::new(3., 4., 5.)).collect();
        let normals = PosedNormals::new(&mesh, &mesh.positions).of_values(&mesh, &posed);
        for (posed, rest) in normals.iter().zip(&mesh.normals.as_ref().unwrap().values) {
            // Two frames and a product: some tens of roundings of numbers up to 1.
            assert!((Vector3::from(*posed) - turn * Vector3::from(*rest)).norm() < 1e-14);
        }
    }

    #[test]
    fn a_hard_edge_stays_hard() {
        let mesh = tent(true);
        // The left slope is laid flat about the ridge; the right one stays.
        let mut posed = mesh.positions.clone();
        posed[0] = Point3::new(-1., 1., 0.);
        posed[1] = Point3::new(-1., 1., 2.);
        let normals = PosedNormals::new(&mesh, &mesh.positions).of_values(&mesh, &posed);
        assert_eq!(normals[1], [0.6, 0.8, 0.0]);
        // The slope rises at 45 degrees but its normal leans by atan(3/4); the lean of 8.13 degrees from the true normal stays.
        let lean = (45.0 - 0.75_f64.atan().to_degrees()).to_radians();
        assert!((Vector3::from(normals[0]) - Vector3::new(lean.sin(), lean.cos(), 0.0)).norm() < 1e-14);
    }

    #[test]
    fn without_normals_the_surface_is_smooth_across_seams() {
        let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        // The tent, split along its ridge into two sheets.
        let positions = vec![
            p(-1., 0., 0.),
            p(-1., 0., 2.),
            p(0., 1., 2.),
            p(0., 1., 0.),
            p(0., 1., 0.),
            p(0., 1., 2.),
            p(1., 0., 2.),
            p(1., 0., 0.),
        ];
        let mut mesh = Mesh { positions, ..Mesh::default() };
        mesh.polygons.push(&[0, 1, 2, 3]);
        mesh.polygons.push(&[4, 5, 6, 7]);
        let normals = PosedNormals::new(&mesh, &mesh.positions);
        for corner in 2..6 {
            assert_eq!(normals.rest()[normals.group_of[corner] as usize], [0.0, 1.0, 0.0]);
        }
    }

    #[test]
    fn a_vertex_may_have_very_many_normals() {
        let n = 3000;
        let rim = |k: u32| f64::from(k) * std::f64::consts::TAU / f64::from(n);
        let mut mesh = Mesh { positions: vec![Point3::new(0.0, 0.0, 1.0)], ..Mesh::default() };
        mesh.positions.extend((0..n).map(|k| Point3::new(rim(k).cos(), rim(k).sin(), 0.0)));
        let values = (0..n).map(|k| [rim(k).cos(), rim(k).sin(), 1.0]).collect();
        // Twice around, so that each normal is met again.
        let mut indices = Vec::new();
        for k in (0..n).chain(0..n) {
            mesh.polygons.push(&[0, 1 + k, 1 + (k + 1) % n]);
            indices.extend([Some(k); 3]);
        }
        mesh.normals = Some(CornerAttribute { values, indices });
        let normals = PosedNormals::new(&mesh, &mesh.positions);
        // Each triangle's normal at the hub and at both ends of its rim, whichever of the two faces it is.
        assert_eq!(normals.rest().len(), 3 * n as usize);
        let (first, second) = normals.group_of.split_at(3 * n as usize);
        assert_eq!(first, second);
    }

    #[test]
    fn polygons_without_area_give_finite_normals() {
        let mut mesh = tent(false);
        mesh.normals = None;
        mesh.positions.fill(Point3::new(1., 2., 3.));
        let normals = PosedNormals::new(&mesh, &mesh.positions);
        assert!(normals.of_groups(&mesh, &mesh.positions).iter().flatten().all(|x| x.is_finite()));
    }
}
