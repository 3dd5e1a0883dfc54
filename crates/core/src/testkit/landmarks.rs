//! The contract of landmarks.

use nalgebra::Point3;

use super::{
    meshes,
    support::{one_thread, watched, with_defects},
};
use crate::{
    Error,
    mesh::{Surface, SurfacePoint},
    stage::{Landmarks, Marker, Proposal, TransferPair},
};

/// The contract of [`Landmarks`], on animals of blocks, which are easy, and on shapes between which nothing corresponds.
///
/// A stage that runs a program has none without settings: it says so.
pub fn landmarks(name: &str, stage: &dyn Landmarks) {
    if stage.command().is_some_and(<[String]>::is_empty) {
        let mesh = meshes::blocky_animal([3, 2, 2]);
        let pair = TransferPair { source: &mesh, target: &mesh, markers: &[], proximity: None };
        assert!(stage.propose(pair).is_err(), "{name}: runs no program and proposes pairs");
        return;
    }
    let short = meshes::blocky_animal([3, 2, 2]);
    let tall = meshes::blocky_animal([5, 4, 3]);
    let propose = |source: &Surface, target: &Surface, markers: &[Marker]| -> Result<Proposal, Error> {
        let pair = TransferPair { source, target, markers, proximity: None };
        let run = || stage.propose(pair).map_err(|error| with_way_out(name, error));
        let proposal = run()?;
        proposal.check(pair).unwrap_or_else(|error| panic!("{name}: {error}"));
        let again = one_thread(|| watched(name, |work| stage.propose_watched(pair, work)));
        let again = again.unwrap_or_else(|error| panic!("{name}: fails on one thread: {error}"));
        assert!(proposal == again, "{name}: other pairs on one thread, or while somebody waits");
        Ok(proposal)
    };
    let clicks = [Marker { name: "nape".into(), source: SurfacePoint::Vertex(5), target: SurfacePoint::Vertex(7) }];
    for (source, target) in [(&short, &tall), (&tall, &with_defects(short.clone()))] {
        // Some stages start from clicks, and say so.
        match propose(source, target, &[]) {
            Ok(proposal) => assert!(!proposal.pairs.is_empty(), "{name}: no pair"),
            Err(Error::Data { hint, .. }) => assert!(hint.contains("clicks"), "{name}: no pair, and no word of clicks"),
            Err(error) => panic!("{name}: {error}"),
        }
        let with_click = propose(source, target, &clicks).unwrap_or_else(|error| panic!("{name}: {error}"));
        for pairs in std::iter::once(&with_click.pairs).chain(&with_click.others) {
            let first = &pairs[0];
            assert!(first.marker == clicks[0] && first.confidence == 1.0, "{name}: the user's marker became {first:?}");
        }
    }
    // Whatever it makes of these, it neither panics nor gives points that do not exist.
    for other in [meshes::tetrahedron(), meshes::icosphere(2), meshes::grid(4, 4), meshes::two_components()] {
        _ = propose(&short, &other, &[]);
        _ = propose(&other, &short, &[]);
    }
    let mut broken = short.clone();
    broken.positions[3] = Point3::new(f64::NAN, 0.0, 0.0);
    assert!(propose(&short, &broken, &[]).is_err(), "{name}: takes a position that is no number");
}

fn with_way_out(name: &str, error: Error) -> Error {
    let needs_hint = matches!(error, Error::Data { .. });
    assert!(!needs_hint || error.hint().is_some(), "{name}: no way out of {error}");
    error
}
