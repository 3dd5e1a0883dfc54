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
        // A sum that reaches the share but for rounding has reached it.
        let wanted = share * self.total * (1.0 - 1e-9);
        self.among_few(share, wanted).unwrap_or_else(|| reaching(wanted, &mut self.values.clone()))
    }

    /// The percentile by one pass over the values: a sample brackets it, and only what lies between is looked at again
    /// (Floyd & Rivest 1975). `None` if the bracket missed it, or there are few values anyway.
    fn among_few(&self, share: f64, wanted: f64) -> Option<f64> {
        if self.values.len() < 4 * SAMPLE {
            return None;
        }
        let step = self.values.len() / SAMPLE;
        let mut sample: Vec<(f64, f64)> = self.values.iter().step_by(step).copied().collect();
        sample.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        // Three standard deviations of a sample's share, and one value more.
        let count = sample.len() as f64;
        let margin = (9.0 * share * (1.0 - share) / count).sqrt() + 1.0 / count;
        let total = weight_of(&sample);
        let at = |share: f64| {
            let mut sum = 0.0;
            sample.iter().find(|(_, weight)| {
                sum += weight;
                sum >= share * total
            })
        };
        let low = at(share - margin).filter(|_| share > margin).map_or(f64::NEG_INFINITY, |(value, _)| *value);
        let high = at(share + margin).filter(|_| share + margin < 1.0).map_or(f64::INFINITY, |(value, _)| *value);
        let (mut below, mut between) = (0.0, Vec::with_capacity(self.values.len() / 4));
        for &(value, weight) in &self.values {
            if value < low {
                below += weight;
            } else if value <= high {
                between.push((value, weight));
            }
        }
        let is_there = below < wanted && below + weight_of(&between) >= wanted;
        is_there.then(|| reaching(wanted - below, &mut between))
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

/// Values of a sample that brackets a percentile.
const SAMPLE: usize = 512;

/// The smallest of `candidates` such that those up to it weigh at least `wanted`.
///
/// Halving the candidates takes time in proportion to their number; sorting takes five times as long.
fn reaching(mut wanted: f64, mut candidates: &mut [(f64, f64)]) -> f64 {
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

fn weight_of(values: &[(f64, f64)]) -> f64 {
    values.iter().map(|(_, weight)| weight).sum()
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::random::Random;

    use super::*;

    #[test]
    fn a_bracket_by_a_sample_changes_no_percentile() {
        let mut random = Random::new(3);
        let mut spread = |power: i32| -> Vec<(f64, f64)> {
            (0..20_000).map(|_| (random.vector().x.powi(power), 1.0 + random.vector().y)).collect()
        };
        let mut sorted = spread(1);
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let equal = vec![(2.5, 1.0); 5_000];
        // Every 39th value is a sample: all others lie elsewhere.
        let missed: Vec<_> = (0..20_000).map(|i| (if i % 39 == 0 { 1.0 } else { f64::from(i) }, 1.0)).collect();
        for values in [spread(1), spread(9), sorted, equal, missed] {
            let distribution = Distribution::weighted(values).unwrap();
            for share in [0.0, 1e-4, 0.25, 0.5, 0.99, 0.999, 1.0] {
                let wanted = share * distribution.total * (1.0 - 1e-9);
                assert_eq!(
                    distribution.percentile(share),
                    reaching(wanted, &mut distribution.values.clone()),
                    "{share}"
                );
            }
        }
    }

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
