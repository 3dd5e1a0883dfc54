//! Strengthens or weakens what another transfer does.

use mimesh_core::{
    Error, Figures, Result, plugin, register,
    spatial::{Orientation, Similarity},
    stage::{BoundTransfer, Pair, Transfer, Transferred, TriangleMap},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Transfer: Exaggerate);

/// Strengthens or weakens the shape change of another transfer: x = M(v) + strength · (x̃ − M(v)), where x̃ is what
/// the other gives and M the rigid motion of the rest shape that comes nearest to it.
///
/// Rigid motion is kept as it is, so the character stays where it belongs. A caricature for 1.2 and more, a calmer
/// motion below 1.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Exaggerate {
    /// How much of the shape change to keep: 0 keeps the rest shape, 1 all of it, 2 doubles it.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub strength: f64,
    /// The transfer; `gradient` if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<Box<dyn Transfer>>,
}

impl Default for Exaggerate {
    fn default() -> Self {
        Self { strength: 1.2, of: None }
    }
}

#[typetag::serde(name = "exaggerate")]
impl Transfer for Exaggerate {
    fn bind(&self, pair: Pair<'_>, map: &TriangleMap) -> Result<Box<dyn BoundTransfer>> {
        Error::check_setting("strength", self.strength, 0.0, 10.0)?;
        let of = match &self.of {
            Some(transfer) => transfer.bind(pair, map)?,
            None => gradient()?.bind(pair, map)?,
        };
        Ok(Box::new(Bound { rest: pair.target.positions.clone(), of, strength: self.strength }))
    }
}

/// A stage reaches another only through its trait; the registry gives an instance by name.
fn gradient() -> Result<Box<dyn Transfer>> {
    let found = plugin::instances::<dyn Transfer>().into_iter().find(|(name, _)| *name == "gradient");
    found.map(|(_, transfer)| transfer).ok_or_else(|| Error::Setting {
        setting: "of",
        expected: "a transfer, since `gradient` is not linked into this program".into(),
        found: "none".into(),
    })
}

#[derive(Debug)]
struct Bound {
    /// V of the target, #V × 3.
    rest: Vec<Point3<f64>>,
    of: Box<dyn BoundTransfer>,
    strength: f64,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        let Transferred { positions, figures } = self.of.transfer(posed)?;
        let motion = nearest_rigid_motion(&self.rest, &positions);
        let exaggerated = |(rest, posed): (&Point3<f64>, &Point3<f64>)| {
            let moved = motion.apply(rest);
            moved + (posed - moved) * self.strength
        };
        let positions = self.rest.iter().zip(&positions).map(exaggerated).collect();
        Ok(Transferred { positions, figures })
    }

    fn figures(&self) -> Figures {
        self.of.figures()
    }
}

/// The rotation and translation of `from` that bring it nearest to `to`, in the mean of squares.
fn nearest_rigid_motion(from: &[Point3<f64>], to: &[Point3<f64>]) -> Similarity {
    let fitted = Similarity::fit(from, to, &vec![1.0; from.len()], Orientation::Fitted);
    let mean =
        |points: &[Point3<f64>]| points.iter().map(|p| p.coords).sum::<nalgebra::Vector3<f64>>() / points.len() as f64;
    Similarity { scale: 1.0, translation: mean(to) - fitted.rotation * mean(from), ..fitted }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::{contracts, meshes, random::Random};

    use super::*;

    /// Gives the pose itself.
    #[derive(Debug)]
    struct Same;

    impl BoundTransfer for Same {
        fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
            Ok(Transferred { positions: posed.to_vec(), figures: Figures::default() })
        }

        fn figures(&self) -> Figures {
            Figures::default()
        }
    }

    fn exaggerate(strength: f64, posed: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let rest = meshes::icosphere(2).positions;
        Bound { rest, of: Box::new(Same), strength }.transfer(posed).unwrap().positions
    }

    fn assert_close(a: &[Point3<f64>], b: &[Point3<f64>]) {
        // Two passes over a hundred coordinates of size 1 round to far less.
        a.iter().zip(b).for_each(|(a, b)| assert!((a - b).norm() < 1e-12, "{a} {b}"));
    }

    #[test]
    fn rigid_motion_is_kept_at_any_strength() {
        let motion = Random::new(1).rigid_motion(3.0);
        let moved: Vec<_> = meshes::icosphere(2).positions.iter().map(|p| motion * p).collect();
        for strength in [0.0, 1.0, 3.0] {
            assert_close(&exaggerate(strength, &moved), &moved);
        }
    }

    #[test]
    fn a_stretch_grows_with_the_strength() {
        let stretched = |by: f64| -> Vec<_> {
            meshes::icosphere(2).positions.iter().map(|p| Point3::new(p.x * (1.0 + by), p.y, p.z)).collect()
        };
        assert_close(&exaggerate(2.0, &stretched(0.2)), &stretched(0.4));
        assert_close(&exaggerate(0.5, &stretched(0.2)), &stretched(0.1));
    }

    #[test]
    fn it_keeps_the_contract_of_a_transfer() {
        contracts::transfer("exaggerate", &Exaggerate::default());
        contracts::round_trips::<dyn Transfer>("exaggerate", &Exaggerate::default());
        let registered = plugin::all().into_iter().find(|plugin| (plugin.name)() == "exaggerate");
        contracts::described(registered.unwrap());
    }
}
