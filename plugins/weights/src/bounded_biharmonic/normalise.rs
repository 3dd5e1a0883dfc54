//! Rows that sum to 1.

use mimesh_core::Figures;
use nalgebra::DMatrix;

use super::{Bound, Normalize, Solved, Task};

/// Below this sum the weights of a vertex say nothing of their proportions.
const MIN_SUM: f64 = 1e-3;

impl Bound {
    /// Divides the rows of the solved weights by their sums, if the settings say so; tells of the sums in any case.
    pub(super) fn normalise(
        &self,
        tasks: &[Task<'_>],
        solved: &[Solved],
        matrix: &mut DMatrix<f64>,
        figures: &mut Figures,
    ) {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut replaced = 0;
        // Handles of a group stand beside each other.
        for (task, of_group) in tasks.iter().zip(solved.chunk_by(|a, b| a.group == b.group)) {
            let mut unbounded = None;
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
                let unbounded: &Vec<Vec<f64>> = unbounded.get_or_insert_with(|| task.all_unbounded());
                let positive: f64 = unbounded.iter().map(|w| w[local].max(0.0)).sum();
                for (found, w) in of_group.iter().zip(unbounded) {
                    matrix[at(found)] = w[local].max(0.0) / positive;
                }
            }
        }
        if !solved.is_empty() {
            figures.set("least_row_sum", least);
            figures.set("greatest_row_sum", most);
            figures.set("rows_taken_from_unbounded_weights", replaced);
        }
    }
}
