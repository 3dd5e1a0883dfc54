//! Strengthens or weakens what another transfer does.

use mimesh_core::{
    Figures, Result,
    plugin::{check_ranges, instance, nested},
    register,
    spatial::{Orientation, Similarity},
    stage::{BindInput, BoundTransfer, Motion, Transfer, TransferPair, Transferred},
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
    pub of: Option<Box<dyn Transfer>>,
}

impl Default for Exaggerate {
    fn default() -> Self {
        Self { strength: 1.2, of: None }
    }
}

#[typetag::serde(name = "exaggerate")]
impl Transfer for Exaggerate {
    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        check_ranges(self)?;
        let of = self.with_other(|of| of.bind(input))?;
        Ok(Box::new(Bound { rest: input.pair.target.positions.clone(), of, strength: self.strength }))
    }

    // What the pipeline asks about this transfer is for the other one to answer.

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        self.with_other(|of| of.check(pair))
    }

    fn needs_correspondence(&self) -> bool {
        self.with_other(|of| Ok(of.needs_correspondence())).unwrap_or(true)
    }

    fn markers_needed(&self) -> usize {
        self.with_other(|of| Ok(of.markers_needed())).unwrap_or(0)
    }

    fn gives_motion(&self) -> bool {
        self.with_other(|of| Ok(of.gives_motion())).unwrap_or(false)
    }

    fn poses_wanted(&self) -> usize {
        self.with_other(|of| Ok(of.poses_wanted())).unwrap_or(0)
    }
}

impl Exaggerate {
    /// A stage reaches another only through its trait; the registry gives an instance by name.
    ///
    /// That is left to the time of use, since a default that asks for another of its own stage would never end.
    fn with_other<T>(&self, ask: impl FnOnce(&dyn Transfer) -> Result<T>) -> Result<T> {
        match &self.of {
            Some(of) => ask(&**of),
            None => ask(nested("of", &instance("gradient"), "gradient")?),
        }
    }
}

#[derive(Debug)]
struct Bound {
    /// V of the target, #V × 3.
    rest: Vec<Point3<f64>>,
    of: Box<dyn BoundTransfer>,
    strength: f64,
}

impl Bound {
    fn exaggerated(&self, Transferred { positions, figures }: Transferred) -> Transferred {
        let motion = nearest_rigid_motion(&self.rest, &positions);
        let exaggerated = |(rest, posed): (&Point3<f64>, &Point3<f64>)| {
            let moved = motion.apply(rest);
            moved + (posed - moved) * self.strength
        };
        let positions = self.rest.iter().zip(&positions).map(exaggerated).collect();
        Transferred { positions, figures }
    }
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        Ok(self.exaggerated(self.of.transfer(posed)?))
    }

    fn motion(&self) -> Option<Box<dyn Motion + '_>> {
        let of = self.of.motion()?;
        Some(Box::new(UnderWay { bound: self, of }))
    }

    fn figures(&self) -> Figures {
        self.of.figures()
    }
}

/// A motion of the other transfer.
struct UnderWay<'a> {
    bound: &'a Bound,
    of: Box<dyn Motion + 'a>,
}

impl Motion for UnderWay<'_> {
    fn frame(&mut self, frame: usize, posed: &[Point3<f64>]) -> Result<Transferred> {
        Ok(self.bound.exaggerated(self.of.frame(frame, posed)?))
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
    use mimesh_core::testkit::{meshes, random::Random};

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
}
