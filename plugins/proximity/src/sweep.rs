//! Pairs of components whose bounding boxes lie close, without looking at all pairs.

use crate::parts::Part;

/// Parts in the order in which their boxes begin along the longest side of the box of all.
///
/// Boxes that begin far behind the end of another one lie far from it, so that a search looks at few of the others.
pub struct Sweep<'a> {
    parts: &'a [Part],
    axis: usize,
    order: Vec<u32>,
    /// The diagonal of the box of all.
    pub diagonal: f64,
}

impl<'a> Sweep<'a> {
    pub fn new(parts: &'a [Part]) -> Self {
        let low = parts.iter().map(|part| part.low).reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let high = parts.iter().map(|part| part.high).reduce(|a, b| a.sup(&b)).unwrap_or_default();
        let axis = (high - low).imax();
        let mut order: Vec<u32> = (0..parts.len() as u32).collect();
        let begin = |&part: &u32| parts[part as usize].low[axis];
        order.sort_by(|a, b| begin(a).total_cmp(&begin(b)).then(a.cmp(b)));
        Self { parts, axis, order, diagonal: (high - low).norm() }
    }

    /// The number of parts.
    pub fn count(&self) -> usize {
        self.order.len()
    }

    /// The pairs of the part at `place` of the order and one behind it, smaller number first, whose boxes may lie within `reach`: among
    /// them are all that do.
    pub fn near(&self, place: usize, reach: f64) -> impl Iterator<Item = [u32; 2]> {
        let a = self.order[place];
        let part = |part: u32| &self.parts[part as usize];
        let begin = move |&b: &u32| part(b).low[self.axis] - part(a).high[self.axis];
        // What rounding takes from a bound of the distance stays within reach.
        let reach = reach * (1.0 + 16.0 * f64::EPSILON);
        self.order[place + 1..].iter().take_while(move |b| begin(b) <= reach).map(move |&b| [a.min(b), a.max(b)])
    }

    /// The part at `place` of the order.
    pub fn part(&self, place: usize) -> u32 {
        self.order[place]
    }
}
