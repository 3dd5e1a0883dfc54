//! Results as bytes: JSON, and vertices as they lie in memory, so that they come back to the last bit.

use nalgebra::Point3;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{
    core::{
        Figures,
        stage::{ProximityGraph, TriangleMap},
    },
    pipeline::judge::Said,
};

/// What is kept of a bound transfer: it is bound anew when poses are missing, for what it holds is no data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OfTransfer {
    /// What it said while binding.
    pub figures: Figures,
    /// Whether its poses are frames of one motion.
    pub motion: bool,
}

/// A posed target and what the transfer says of it.
pub type Moved = (Vec<Point3<f64>>, Figures);

/// A result that is kept.
pub trait Keep: Sized {
    /// As bytes.
    fn to_bytes(&self) -> Vec<u8>;

    /// From such bytes; `None` if they are of another make.
    fn from_bytes(bytes: &[u8]) -> Option<Self>;
}

fn json<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    serde_json::from_slice(bytes).ok()
}

impl Keep for ProximityGraph {
    fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        json(bytes)
    }
}

impl Keep for TriangleMap {
    fn to_bytes(&self) -> Vec<u8> {
        // A map's own notation, that of files, is without figures.
        serde_json::to_vec(&(self, &self.figures)).unwrap_or_default()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (map, figures): (Self, Figures) = json(bytes)?;
        Some(Self { figures, ..map })
    }
}

impl Keep for OfTransfer {
    fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        json(bytes)
    }
}

impl Keep for Said {
    fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        json(bytes)
    }
}

impl Keep for Moved {
    fn to_bytes(&self) -> Vec<u8> {
        let (positions, figures) = self;
        let mut bytes = (positions.len() as u64).to_le_bytes().to_vec();
        positions.iter().flat_map(|p| [p.x, p.y, p.z]).for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(serde_json::to_vec(figures).unwrap_or_default());
        bytes
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (count, rest) = bytes.split_at_checked(8)?;
        let count = usize::try_from(u64::from_le_bytes(count.try_into().ok()?)).ok()?;
        let (numbers, figures) = rest.split_at_checked(count.checked_mul(24)?)?;
        let number = |chunk: &[u8]| f64::from_le_bytes([0, 1, 2, 3, 4, 5, 6, 7].map(|i| chunk[i]));
        let point = |chunk: &[u8]| Point3::new(number(chunk), number(&chunk[8..]), number(&chunk[16..]));
        Some((numbers.chunks_exact(24).map(point).collect(), json(figures)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_come_back_to_the_last_bit() {
        let mut figures = Figures::default();
        figures.set("residual", 0.1 + 0.2);
        figures.warn("a remark");
        let positions =
            vec![Point3::new(0.1 + 0.2, -0.0, f64::MIN_POSITIVE / 8.0), Point3::new(1e300, 3.0, -1.0 / 3.0)];
        let moved: Moved = (positions, figures);
        let bytes = moved.to_bytes();
        let (back, figures) = Moved::from_bytes(&bytes).unwrap();
        let bits = |points: &[Point3<f64>]| -> Vec<u64> {
            points.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits).collect()
        };
        assert_eq!((bits(&back), figures), (bits(&moved.0), moved.1));
        for length in 0..bytes.len() {
            assert!(Moved::from_bytes(&bytes[..length]).is_none(), "{length} of {} bytes", bytes.len());
        }
    }

    #[test]
    fn figures_come_back_with_or_without_warnings() {
        for warnings in [vec![], vec!["a".to_owned()]] {
            let mut figures = Figures { warnings, ..Figures::default() };
            figures.set("energies", vec![1.5, 0.1 + 0.2]);
            let kept = OfTransfer { figures, motion: true };
            assert_eq!(OfTransfer::from_bytes(&kept.to_bytes()), Some(kept));
        }
    }
}
