//! Rows that sum to 1.

use mimesh_core::Figures;
use nalgebra::DMatrix;

use super::{Bound, Normalize, Solved};

/// Below this sum the weights of a vertex say nothing of their proportions.
const MIN_SUM: f64 = 1e-3;

impl Bound {
    /// Divides the rows of the solved weights by their sums, if the settings say so; tells of the sums in any case.
    pub(super) fn normalise(&self, solved: &[Solved], matrix: &mut DMatrix<f64>, figures: &mut Figures) {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut replaced = 0;
        // Handles of a group stand beside each other.
        for of_group in solved.chunk_by(|a, b| a.group == b.group) {
            for (local, &v) in self.domain.groups[of_group[0].group].vertices.iter().enumerate() {
                let at = |found: &Solved| (v as usize, found.handle);
                let sum: f64 = of_group.iter().map(|found| matrix[at(found)]).sum();
                (least, most) = (least.min(sum), most.max(sum));
                if self.settings.normalize == Normalize::None {
                    continue;
                }
                if sum >= MIN_SUM {
                    of_group.iter().for_each(|found| matrix[at(found)] /= sum);
                    continue;
                }
                // Unbounded weights sum to 1, so that their positive parts sum to 1 or more.
                replaced += 1;
                let positive: f64 = of_group.iter().map(|found| found.unbounded[local].max(0.0)).sum();
                of_group.iter().for_each(|found| matrix[at(found)] = found.unbounded[local].max(0.0) / positive);
            }
        }
        if !solved.is_empty() {
            figures.set("least_row_sum", least);
            figures.set("greatest_row_sum", most);
            figures.set("rows_taken_from_unbounded_weights", replaced);
        }
    }
}
