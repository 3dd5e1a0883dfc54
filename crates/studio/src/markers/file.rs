//! The document as a file of markers, and the other way round.

use mimesh_markers::{MarkerFile, MarkerMesh, MarkerPair, MeshRole};

use super::pair::{Content, Pair, Point};

/// The file of `pairs`, with the positions of their points but without the meshes that they are on.
pub fn of_pairs<'a>(pairs: impl Iterator<Item = &'a Pair>, meshes: [MarkerMesh<'_>; 2]) -> MarkerFile {
    let pair = |pair: &Pair| {
        let Content { name, note, points, status, confidence } = pair.content.clone();
        let [source, target] = points.map(|point| point.map(Into::into));
        let at = MeshRole::BOTH.map(|role| {
            let point = if role == MeshRole::Source { source } else { target };
            point.and_then(|point| meshes[role.index()].position(point))
        });
        MarkerPair { name, source, target, note, status: status.into(), confidence, at, location: None }
    };
    MarkerFile { pairs: pairs.map(pair).collect(), ..MarkerFile::default() }
}

/// What a pair of a file holds.
pub fn content(pair: &MarkerPair) -> Content {
    Content {
        name: pair.name.clone(),
        note: pair.note.clone(),
        points: MeshRole::BOTH.map(|role| pair.point(role).map(Point::from)),
        status: pair.status.into(),
        confidence: pair.confidence,
    }
}
