//! Markers from the landmarks that two meshes bring.

use std::collections::HashMap;

use mimesh_core::mesh::{MeshPoint, MeshSequence};

use crate::model::{MarkerFile, MarkerPair};

/// The landmarks that both meshes have, as markers: pairs of equal names, in the order of the source.
pub fn from_landmarks(source: &MeshSequence, target: &MeshSequence) -> MarkerFile {
    let targets: HashMap<&str, MeshPoint> = target.landmarks.iter().map(|l| (l.name.as_str(), l.point)).collect();
    let mut markers = MarkerFile::default();
    for landmark in &source.landmarks {
        if let Some(target) = targets.get(landmark.name.as_str()) {
            let name = Some(landmark.name.clone());
            markers.pairs.push(MarkerPair { name, ..MarkerPair::new(landmark.point, *target) });
        }
    }
    markers
}

#[cfg(test)]
mod tests {
    use mimesh_core::mesh::Landmark;

    use super::*;

    fn with_landmarks(names: [&str; 2]) -> MeshSequence {
        let points = (0..).map(MeshPoint::Vertex);
        let landmarks = names.iter().zip(points).map(|(name, point)| Landmark { name: name.to_string(), point });
        MeshSequence { landmarks: landmarks.collect(), ..MeshSequence::default() }
    }

    #[test]
    fn landmarks_of_equal_names_are_markers() {
        let file = from_landmarks(&with_landmarks(["nose", "tail"]), &with_landmarks(["ear", "nose"]));
        let points: Vec<_> = file.pairs.iter().map(|pair| (pair.source, pair.target)).collect();
        assert_eq!(points, [(Some(MeshPoint::Vertex(0)), Some(MeshPoint::Vertex(1)))]);
    }
}
