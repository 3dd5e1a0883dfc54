//! Mean, percentiles and the like of weighted values.

/// Values with weights.
pub struct Distribution {
    /// Values and weights, in the order given.
    values: Vec<(f64, f64)>,
    /// Sum of the weights.
    total: f64,
}

impl Distribution {
    /// The finite ones among pairs of a value and its weight (≥ 0); `None` if no finite value has a weight above 0.
    pub fn weighted(values: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let values: Vec<(f64, f64)> =
            values.into_iter().filter(|(value, weight)| value.is_finite() && *weight > 0.0).collect();
        let total = weight_of(&values);
        (!values.is_empty()).then_some(Self { values, total })
    }

    /// The finite ones among `values`, with equal weights; `None` if there are none.
    pub fn unweighted(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        Self::weighted(values.into_iter().map(|value| (value, 1.0)))
    }

    /// The smallest value such that those up to it have at least `share` (0 to 1) of the weight.
    pub fn percentile(&self, share: f64) -> f64 {
        let mut values = self.values.clone();
        let mut candidates = &mut values[..];
        // A sum that reaches the share but for rounding has reached it.
        let mut wanted = share * self.total * (1.0 - 1e-9);
        // Halving the candidates takes time in proportion to the number of values; sorting takes five times as long.
        while candidates.len() > 1 {
            let half = candidates.len() / 2;
            candidates.select_nth_unstable_by(half, |a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
            let (low, high) = candidates.split_at_mut(half);
            let below = weight_of(low);
            if below >= wanted {
                candidates = low;
            } else {
                wanted -= below;
                candidates = high;
            }
        }
        candidates[0].0
    }

    /// The largest value.
    pub fn max(&self) -> f64 {
        self.values.iter().map(|(value, _)| *value).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The weighted mean.
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|(value, weight)| value * weight).sum::<f64>() / self.total
    }

    /// The root of the weighted mean square.
    pub fn rms(&self) -> f64 {
        (self.values.iter().map(|(value, weight)| value * value * weight).sum::<f64>() / self.total).sqrt()
    }

    /// The number of values.
    pub fn count(&self) -> usize {
        self.values.len()
    }
}

/// The index of the largest finite value among `values` (≥ 0); `None` if none is finite.
///
/// Values that differ by rounding count as equal, and the first of them wins. So the choice does not depend on where a mesh lies.
pub fn first_largest(values: &[f64]) -> Option<usize> {
    let largest = values.iter().copied().filter(|x| x.is_finite()).reduce(f64::max)?;
    values.iter().position(|x| x.is_finite() && *x >= largest * (1.0 - 1e-9))
}

fn weight_of(values: &[(f64, f64)]) -> f64 {
    values.iter().map(|(_, weight)| weight).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_go_by_weight() {
        let distribution =
            Distribution::weighted([(5.0, 1.0), (1.0, 98.0), (9.0, 1.0), (f64::NAN, 7.0), (100.0, 0.0)]).unwrap();
        assert_eq!(distribution.count(), 3);
        assert_eq!(
            [0.0, 0.5, 0.98, 0.985, 0.99, 1.0].map(|q| distribution.percentile(q)),
            [1.0, 1.0, 1.0, 5.0, 5.0, 9.0]
        );
        assert_eq!(distribution.max(), 9.0);
        assert!((distribution.mean() - 1.12).abs() < 1e-15, "(98 + 5 + 9) / 100 within rounding");
        assert!(Distribution::unweighted([f64::INFINITY]).is_none());
    }
}
