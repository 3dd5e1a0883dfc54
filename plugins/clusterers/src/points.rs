//! Points of a space of many dimensions, and distances between them.

/// Points, one a row.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    values: Vec<f64>,
    /// Length of a row: the dimensions, filled up with zeros to a multiple of [`LANES`].
    stride: usize,
}

/// Sums of distances run in this many parts, which a processor can do at once.
const LANES: usize = 8;

impl Points {
    /// `count` points at the origin.
    pub(crate) fn zeros(count: usize, dimensions: usize) -> Self {
        let stride = dimensions.max(1).next_multiple_of(LANES);
        Self { values: vec![0.0; count * stride], stride }
    }

    /// `count` points at the origin of the same space.
    pub(crate) fn like(&self, count: usize) -> Self {
        Self { values: vec![0.0; count * self.stride], stride: self.stride }
    }

    pub(crate) fn len(&self) -> usize {
        self.values.len() / self.stride
    }

    #[inline(always)]
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.stride..][..self.stride]
    }

    #[inline(always)]
    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * self.stride..][..self.stride]
    }

    #[inline(always)]
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.stride)
    }
}

/// ‖a − b‖² of rows.
#[inline(always)]
pub(crate) fn square_distance(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for lane in 0..LANES {
            let difference = a[lane] - b[lane];
            sums[lane] += difference * difference;
        }
    }
    sums.iter().sum()
}

/// ‖a − b‖² of rows, or some number of at least `limit` if it is that large: it stops adding when that is clear.
#[inline(always)]
pub(crate) fn square_distance_below(a: &[f64], b: &[f64], limit: f64) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.chunks(2 * LANES).zip(b.chunks(2 * LANES)) {
        sum += square_distance(a, b);
        if sum >= limit {
            break;
        }
    }
    sum
}
