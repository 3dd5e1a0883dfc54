//! Whether poses are in another unit or axes than their rest.

use mimesh_core::{
    mesh::Surface,
    spatial::{LengthUnit, MeshUnits, Orientation, Similarity, UnitAxes, UpAxis, angle_between},
};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::{
    formats::Formats,
    input::{PoseInput, RestMesh, evenly_spaced, read_pose},
};

/// The most poses that are looked at; all of them must agree.
const MAX_POSES: usize = 3;

/// The most edges that are measured of a pose.
const MAX_EDGES: usize = 30_000;

/// A ratio of lengths is that of two units up to this factor. Bodies that bend keep most of their edges much better.
const MAX_STRETCH: f64 = 1.05;

/// A turn is one of axes if the rotation of least squares is no farther from it, in degrees.
const MAX_DEGREES: f64 = 30.0;

/// A pose is turned as a whole if the turned rest is no farther from it, relative to its extent. Arms that hang down are that far
/// from stretched ones.
const MAX_MISFIT: f64 = 0.4;

/// In which units and axes the rest and its poses are, if these differ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Difference {
    /// The units of rest and pose.
    units: Option<[LengthUnit; 2]>,
    /// The upward axes of rest and pose.
    ups: Option<[UpAxis; 2]>,
}

/// A warning if the poses are the rest in another unit or axes, with the keys that say so; `known` is what is known of the rest.
pub fn warning_of_pose_units(
    source: &RestMesh,
    poses: &[PoseInput],
    formats: &Formats,
    known: MeshUnits,
) -> Option<String> {
    let mut all: Option<Difference> = None;
    let mut count = 0;
    for i in evenly_spaced(poses.len(), MAX_POSES) {
        // A pose that cannot be read is reported when its turn comes.
        let Ok(positions) = read_pose(source, formats, &poses[i].from) else { continue };
        let Ok(posed) = source.surface.from_mesh(&positions) else { continue };
        let found = Difference::between(&source.surface, &posed);
        let agreed = match all {
            None => found,
            Some(others) => Difference {
                units: others.units.filter(|units| found.units == Some(*units)),
                ups: others.ups.filter(|ups| found.ups == Some(*ups)),
            },
        };
        if agreed == Difference::default() {
            return None;
        }
        all = Some(agreed);
        count += 1;
    }
    all.map(|difference| difference.warning(count, source.poses_change, known))
}

impl Difference {
    fn between(rest: &Surface, posed: &[Point3<f64>]) -> Self {
        let units = edge_ratio(rest, posed).and_then(units_of);
        Self { units, ups: turn(&rest.positions, posed) }
    }

    fn warning(self, count: usize, change: UnitAxes, known: MeshUnits) -> String {
        let [rest, pose] = [0, 1].map(|k| MeshUnits { unit: self.units.map(|u| u[k]), up: self.ups.map(|u| u[k]) });
        let looked_at =
            if count == 1 { "the pose that was".into() } else { format!("each of the {count} poses that were") };
        let found = UnitAxes::between(rest, pose);
        if change != UnitAxes::IDENTITY {
            return format!(
                "poses differ from their rest as a whole after `poses_unit` and `poses_up`: {looked_at} looked at is the rest {found}; \
                 change these keys"
            );
        }
        let mut keys = Vec::new();
        // What is known already need not be said.
        keys.extend(rest.unit.filter(|_| rest.unit != known.unit).map(|unit| format!("unit: {}", unit.name())));
        keys.extend(rest.up.filter(|_| rest.up != known.up).map(|up| format!("up: {}", up.name())));
        keys.extend(pose.unit.map(|unit| format!("poses_unit: {}", unit.name())));
        keys.extend(pose.up.map(|up| format!("poses_up: {}", up.name())));
        let unless = match self.units {
            Some(_) => "",
            None => "; if the shape really lies in its poses, nothing is to be done",
        };
        format!(
            "poses are in another unit or axes than their rest: {looked_at} looked at is the rest {found}; \
             say `source: {{ {} }}`, which takes them into those of the rest{unless}",
            keys.join(", ")
        )
    }
}

/// The median of the lengths of edges of the pose relative to those at rest; `None` if none has a length.
fn edge_ratio(rest: &Surface, posed: &[Point3<f64>]) -> Option<f64> {
    let step = (3 * rest.triangles.len()).div_ceil(MAX_EDGES).max(1);
    let edges = rest.triangles.iter().step_by(step).flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let length = |positions: &[Point3<f64>], [a, b]: [u32; 2]| (positions[b as usize] - positions[a as usize]).norm();
    let ratios = edges.map(|edge| length(posed, edge) / length(&rest.positions, edge));
    let mut ratios: Vec<f64> = ratios.filter(|ratio| ratio.is_finite()).collect();
    let middle = ratios.len() / 2;
    (!ratios.is_empty()).then(|| *ratios.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The two different units of which the first is `ratio` of the second.
fn units_of(ratio: f64) -> Option<[LengthUnit; 2]> {
    let pairs = LengthUnit::ALL.into_iter().flat_map(|rest| LengthUnit::ALL.map(|pose| [rest, pose]));
    let off = |[rest, pose]: [LengthUnit; 2]| (ratio / rest.factor_to(pose)).ln().abs();
    let nearest = pairs.min_by(|a, b| off(*a).total_cmp(&off(*b)))?;
    (nearest[0] != nearest[1] && off(nearest) <= MAX_STRETCH.ln()).then_some(nearest)
}

/// The upward axes that turn the rest into the pose, if it is turned as a whole.
fn turn(rest: &[Point3<f64>], posed: &[Point3<f64>]) -> Option<[UpAxis; 2]> {
    let laid = Similarity::fit(rest, posed, &vec![1.0; rest.len()], Orientation::Fitted);
    let pairs = UpAxis::ALL.into_iter().flat_map(|rest| UpAxis::ALL.map(|pose| [rest, pose]));
    let mut turns = pairs.filter(|[rest, pose]| rest != pose);
    let found = turns.find(|ups| angle_between(&laid.rotation, &rotation(*ups)) <= MAX_DEGREES)?;
    let mean = posed.iter().map(|p| p.coords).sum::<Vector3<f64>>() / posed.len() as f64;
    let distance: f64 = rest.iter().zip(posed).map(|(p, q)| (laid.apply(p) - q).norm_squared()).sum();
    let extent: f64 = posed.iter().map(|q| (q.coords - mean).norm_squared()).sum();
    (distance <= MAX_MISFIT * MAX_MISFIT * extent).then_some(found)
}

/// The rotation from one upward axis to another; that from Z to X is also that from X to Z.
fn rotation([rest, pose]: [UpAxis; 2]) -> Matrix3<f64> {
    let up = |up| MeshUnits { unit: None, up: Some(up) };
    UnitAxes::between(up(rest), up(pose)).matrix()
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Mesh, testkit::meshes::ellipsoid};

    use super::*;

    fn surface() -> Surface {
        let (positions, triangles) = ellipsoid(8, 10);
        let long = positions.iter().map(|p| Point3::new(p.x, 1.5 * p.y + 0.2 * p.x * p.x, 0.7 * p.z)).collect();
        Surface::new(&Mesh::from_triangles(long, &triangles)).unwrap()
    }

    #[test]
    fn every_pair_of_units_and_axes_is_recognised_in_a_bent_pose() {
        let surface = surface();
        let bent: Vec<_> = surface.positions.iter().map(|p| Point3::new(p.x + 0.15 * p.y * p.y, p.y, p.z)).collect();
        for rest in LengthUnit::ALL {
            for pose in LengthUnit::ALL {
                for up in UpAxis::ALL {
                    for poses_up in UpAxis::ALL {
                        let change = UnitAxes::between(
                            MeshUnits { unit: Some(rest), up: Some(up) },
                            MeshUnits { unit: Some(pose), up: Some(poses_up) },
                        );
                        let posed: Vec<_> = bent.iter().map(|p| change.apply(p)).collect();
                        let found = Difference::between(&surface, &posed);
                        assert_eq!(found.units, (rest != pose).then_some([rest, pose]));
                        let ups = (up != poses_up).then_some([up, poses_up]);
                        assert_eq!(found.ups.map(rotation), ups.map(rotation), "{ups:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn growth_and_turns_about_the_upward_axis_are_poses() {
        let surface = surface();
        let of = |change: &dyn Fn(&Point3<f64>) -> Point3<f64>| {
            let posed: Vec<_> = surface.positions.iter().map(change).collect();
            Difference::between(&surface, &posed)
        };
        assert_eq!(of(&|p| p * 2.0), Difference::default());
        assert_eq!(of(&|p| p * 0.5), Difference::default());
        assert_eq!(of(&|p| Point3::new(p.z, p.y, -p.x)), Difference::default());
        assert_eq!(of(&|p| Point3::new(-p.x, -p.y, p.z)), Difference::default());
        // All on one point: there is no ratio, and nothing is turned.
        assert_eq!(of(&|_| Point3::origin()), Difference::default());
    }
}
