//! Results as bytes: JSON, and vertices as they lie in memory, so that they come back to the last bit.

use mimesh_core::{
    Figures,
    stage::{Proposal, ProximityGraph, TriangleMap},
};
use nalgebra::Point3;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{json::to_bytes, metrics::PoseMetrics};

/// What is cached of a bound transfer.
///
/// A bound transfer itself is no data; it is bound again when poses are missing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransferSummary {
    /// What the transfer reported while it was bound.
    pub figures: Figures,
    /// Whether its poses are frames of one motion.
    pub motion: bool,
}

/// The pairs of vertices of a source that coincide at rest and part in its poses, sorted, the smaller vertex first.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenedSeams(pub Vec<[u32; 2]>);

/// A posed target with what the transfer reports of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosedTarget {
    /// The vertices of the target's mesh (#V of the file).
    pub positions: Vec<Point3<f64>>,
    /// What the transfer reports of the pose.
    pub figures: Figures,
}

/// A result that can be cached.
pub trait CacheCodec: Sized {
    /// The result as bytes.
    fn encode(&self) -> Vec<u8>;

    /// The result from such bytes; `None` if they hold something else.
    fn decode(bytes: &[u8]) -> Option<Self>;
}

fn from_json<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    serde_json::from_slice(bytes).ok()
}

/// Implements [`CacheCodec`] by JSON for plain data.
macro_rules! json_codec {
    ($($data:ty),*) => {
        $(impl CacheCodec for $data {
            fn encode(&self) -> Vec<u8> {
                to_bytes(self)
            }

            fn decode(bytes: &[u8]) -> Option<Self> {
                from_json(bytes)
            }
        })*
    };
}

json_codec!(OpenedSeams, Proposal, ProximityGraph, TransferSummary, PoseMetrics);

impl CacheCodec for TriangleMap {
    fn encode(&self) -> Vec<u8> {
        // A map's own notation, that of files, is without figures.
        to_bytes(&(self, &self.figures))
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        let (map, figures): (Self, Figures) = from_json(bytes)?;
        Some(Self { figures, ..map })
    }
}

impl CacheCodec for PosedTarget {
    fn encode(&self) -> Vec<u8> {
        let mut bytes = (self.positions.len() as u64).to_le_bytes().to_vec();
        self.positions.iter().flat_map(|p| [p.x, p.y, p.z]).for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(to_bytes(&self.figures));
        bytes
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        let (count, rest) = bytes.split_first_chunk::<8>()?;
        let count = usize::try_from(u64::from_le_bytes(*count)).ok()?;
        let (numbers, figures) = rest.split_at_checked(count.checked_mul(24)?)?;
        let (numbers, _) = numbers.as_chunks::<8>();
        let (points, _) = numbers.as_chunks::<3>();
        let positions = points.iter().map(|p| Point3::from(p.map(f64::from_le_bytes))).collect();
        Some(Self { positions, figures: from_json(figures)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(points: &[Point3<f64>]) -> Vec<u64> {
        points.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits).collect()
    }

    #[test]
    fn vertices_come_back_to_the_last_bit() {
        let mut figures = Figures::default();
        figures.set("residual", 0.1 + 0.2);
        figures.warn("a remark");
        let positions =
            vec![Point3::new(0.1 + 0.2, -0.0, f64::MIN_POSITIVE / 8.0), Point3::new(1e300, 3.0, -1.0 / 3.0)];
        let posed = PosedTarget { positions, figures };
        let bytes = posed.encode();
        let back = PosedTarget::decode(&bytes).unwrap();
        assert_eq!((bits(&back.positions), back.figures), (bits(&posed.positions), posed.figures));
        for length in 0..bytes.len() {
            assert!(PosedTarget::decode(&bytes[..length]).is_none(), "{length} of {} bytes", bytes.len());
        }
    }

    #[test]
    fn figures_come_back_with_or_without_warnings() {
        for warnings in [vec![], vec!["a".to_owned()]] {
            let mut figures = Figures { warnings, ..Figures::default() };
            figures.set("energies", vec![1.5, 0.1 + 0.2]);
            let summary = TransferSummary { figures, motion: true };
            assert_eq!(TransferSummary::decode(&summary.encode()), Some(summary));
        }
    }
}
