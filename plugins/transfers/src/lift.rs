//! The turns of a surface, followed from triangle to triangle.

use mimesh_core::{
    mesh::Surface,
    operators::{mean_quaternion, rotations},
};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

/// Neighbours turn alike if their quaternions have at least this product, but for the sign: within 37 degrees.
const ALIKE: f64 = 0.95;

/// Gives rotations of triangles of the source as quaternions whose signs agree along the surface.
///
/// ±q are the same rotation. Along edges where neighbours turn nearly alike the sign is carried on, so that the quaternions
/// of two triangles tell by which way one turned against the other, up to a full turn: one end of a bar that is twisted by 270
/// degrees is then not taken for one twisted by −90.
#[derive(Debug)]
pub struct Lift {
    adjacent: Vec<[u32; 2]>,
    triangles: usize,
    /// The triangles whose turns are asked for.
    asked: Vec<u32>,
}

impl Lift {
    /// Prepares for poses of `source`; `asked` are the triangles whose turns are asked for.
    pub fn new(source: &Surface, asked: Vec<u32>) -> Self {
        Self { adjacent: source.topology().adjacent, triangles: source.triangle_count(), asked }
    }

    /// The quaternions of the triangles asked for, when triangles have the deformation gradients `gradient`.
    ///
    /// Signs are carried over the edges of the spanning tree along which neighbours turn most alike, so that a few folded
    /// triangles mislead none but themselves. Pieces of the surface take the sign that is nearer to the first.
    pub fn quaternions(&self, gradient: impl Fn(usize) -> Matrix3<f64>) -> Vec<UnitQuaternion<f64>> {
        let gradients: Vec<_> = (0..self.triangles).map(gradient).collect();
        let quaternion = |r| UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(r));
        let mut all: Vec<_> = rotations(&gradients).into_iter().map(quaternion).collect();
        let signs = self.signs(&all, ALIKE);
        // Pieces in the order of their first triangles.
        let (mut pieces, mut number) = (Vec::<Vec<usize>>::new(), vec![None; self.triangles]);
        for (t, q) in all.iter_mut().enumerate() {
            let (root, flips) = signs.find(t as u32);
            if flips {
                *q = UnitQuaternion::new_unchecked(-q.into_inner());
            }
            let piece = *number[root as usize].get_or_insert(pieces.len());
            if piece == pieces.len() {
                pieces.push(vec![]);
            }
            pieces[piece].push(t);
        }
        let mut first = None;
        for piece in &pieces {
            let mean = mean_quaternion(piece.iter().map(|&t| (1.0, all[t])));
            if first.get_or_insert(mean).coords.dot(&mean.coords) < 0.0 {
                piece.iter().for_each(|&t| all[t] = UnitQuaternion::new_unchecked(-all[t].into_inner()));
            }
        }
        self.asked.iter().map(|&t| all[t as usize]).collect()
    }

    /// The signs of quaternions `all` along the spanning tree; neighbours turn `alike` if their product is at least that.
    fn signs(&self, all: &[UnitQuaternion<f64>], alike: f64) -> Signs {
        let dot = |[a, b]: [u32; 2]| all[a as usize].coords.dot(&all[b as usize].coords);
        let edges: Vec<([u32; 2], f64)> = self.adjacent.iter().map(|&edge| (edge, dot(edge))).collect();
        let sorted = |mut edges: Vec<([u32; 2], f64)>| {
            edges.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            edges
        };
        // Most neighbours turn alike. Where these agree around every ring, the tree among them says no more than they all.
        let (close, others): (Vec<_>, Vec<_>) = edges.iter().copied().partition(|(_, dot)| dot.abs() >= alike);
        let mut signs = Signs::new(self.triangles);
        if close.into_iter().all(|([a, b], dot)| signs.join(a, b, dot < 0.0)) {
            sorted(others).into_iter().for_each(|([a, b], dot)| _ = signs.join(a, b, dot < 0.0));
            return signs;
        }
        let mut signs = Signs::new(self.triangles);
        sorted(edges).into_iter().for_each(|([a, b], dot)| _ = signs.join(a, b, dot < 0.0));
        signs
    }
}

/// Sets of triangles, each with a sign relative to the root of its set.
struct Signs {
    parent: Vec<u32>,
    /// Whether the sign differs from the parent's.
    flips: Vec<bool>,
    size: Vec<u32>,
}

impl Signs {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect(), flips: vec![false; count], size: vec![1; count] }
    }

    /// The root of the set of `t`, and whether the sign of `t` differs from it.
    fn find(&self, mut t: u32) -> (u32, bool) {
        let mut flips = false;
        // Joining by size keeps paths short.
        while self.parent[t as usize] != t {
            flips ^= self.flips[t as usize];
            t = self.parent[t as usize];
        }
        (t, flips)
    }

    /// Joins the sets of `a` and `b`, whose signs differ if `differ`; does nothing if they are one. Whether the signs are so afterwards.
    fn join(&mut self, a: u32, b: u32, differ: bool) -> bool {
        let ((a, a_flips), (b, b_flips)) = (self.find(a), self.find(b));
        if a == b {
            return a_flips ^ b_flips == differ;
        }
        let (root, child) = if self.size[a as usize] >= self.size[b as usize] { (a, b) } else { (b, a) };
        self.parent[child as usize] = root;
        self.flips[child as usize] = differ ^ a_flips ^ b_flips;
        self.size[root as usize] += self.size[child as usize];
        true
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::{operators::logarithm, testkit::meshes};
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    #[test]
    fn the_ends_of_a_twisted_cylinder_tell_by_which_way_they_were_twisted() {
        let surface = meshes::cylinder(8, 20, 4.0);
        let height = |t: usize| surface.corners(&surface.positions, t).iter().map(|p| p.y).sum::<f64>() / 3.0;
        let by_height = |a: &usize, b: &usize| height(*a).total_cmp(&height(*b));
        let lowest = (0..surface.triangle_count()).min_by(by_height).expect("triangles");
        let highest = (0..surface.triangle_count()).max_by(by_height).expect("triangles");
        let lift = Lift::new(&surface, vec![lowest as u32, highest as u32]);
        for degrees in [90.0, -90.0, 170.0, 190.0, 270.0, -270.0, 340.0] {
            let per_unit = f64::to_radians(degrees) / (height(highest) - height(lowest));
            let turn = |t: usize| *Rotation3::from_axis_angle(&Vector3::y_axis(), per_unit * height(t)).matrix();
            let [low, high] = lift.quaternions(turn)[..] else { panic!("two were asked for") };
            let found = logarithm(&(low.inverse() * high)).y.to_degrees();
            assert!((found - degrees).abs() < 1e-9, "{degrees}: {found}");
        }
    }

    #[test]
    fn neighbours_that_turn_alike_need_no_order() {
        let surface = meshes::cylinder(16, 12, 4.0);
        let lift = Lift::new(&surface, vec![]);
        let centre =
            |t: usize| surface.corners(&surface.positions, t).iter().map(|p| p.coords).sum::<Vector3<f64>>() / 3.0;
        // Once around the cylinder is a full turn for the last one, so that no signs agree around it.
        for (along, around, noise) in
            [(0.4, 0.0, 0.0), (1.5, 0.0, 0.3), (0.2, 0.0, 3.0), (0.1, 1.0, 0.2), (0.0, 1.0, 0.0)]
        {
            let turn = |t: usize| {
                let c = centre(t);
                let angle = along * c.y + around * c.z.atan2(c.x) + noise * (t as f64 * 12.9898).sin();
                let sign = if t.is_multiple_of(3) { -1.0 } else { 1.0 };
                let q = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle);
                UnitQuaternion::new_unchecked(q.into_inner() * sign)
            };
            let all: Vec<_> = (0..surface.triangle_count()).map(turn).collect();
            let [fast, plain] = [ALIKE, 2.0].map(|alike| lift.signs(&all, alike));
            let relative = |signs: &Signs, t: u32| {
                let ((a, flips), (b, of_first)) = (signs.find(t), signs.find(0));
                assert_eq!(a, b, "one piece");
                flips ^ of_first
            };
            for t in 0..all.len() as u32 {
                assert_eq!(relative(&fast, t), relative(&plain, t), "{t} at {along} {around} {noise}");
            }
        }
    }
}
