//! Colours of vertices, which an FBX has at corners.

use std::collections::BTreeMap;

use ufbx::VertexVec4;

/// The colours of vertices: the means of those of their corners.
#[derive(Default)]
pub struct VertexColors {
    /// The sum of the colours of each vertex that has any, and their number.
    sums: BTreeMap<usize, ([f64; 4], f64)>,
    /// The number of vertices.
    count: usize,
    /// Whether corners of a vertex differ.
    differ: bool,
}

impl VertexColors {
    /// The colour of a corner of `vertex`.
    pub fn add(&mut self, colors: &VertexVec4, corner: usize, vertex: usize) {
        self.count = self.count.max(vertex + 1);
        let index = colors.indices.get(corner).copied();
        let Some(value) = index.and_then(|index| colors.values.get(index as usize)) else { return };
        let value =
            [value.x, value.y, value.z, value.w].map(|part| if part.is_nan() { 1.0 } else { part.clamp(0.0, 1.0) });
        let (sum, number) = self.sums.entry(vertex).or_insert(([0.0; 4], 0.0));
        // A part of the mean is off by rounding only, if all corners are alike.
        self.differ |= sum.iter().zip(value).any(|(sum, part)| *number > 0.0 && (sum / *number - part).abs() > 1e-9);
        sum.iter_mut().zip(value).for_each(|(sum, part)| *sum += part);
        *number += 1.0;
    }

    /// The colours of `count` vertices, white where a mesh has none; that corners differ is told in `left_out`.
    pub fn finish(self, count: usize, left_out: &mut Vec<String>) -> Option<Vec<[f64; 4]>> {
        if self.differ {
            left_out.push("colours that differ at the corners of a vertex".into());
        }
        let color = |vertex| self.sums.get(&vertex).map_or([1.0; 4], |(sum, number)| sum.map(|part| part / number));
        (!self.sums.is_empty()).then(|| (0..count).map(color).collect())
    }
}
