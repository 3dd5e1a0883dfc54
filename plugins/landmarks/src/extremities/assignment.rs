//! The cheapest pairing of two sets.

/// The column of each row that costs least in sum, by the Hungarian method with potentials [Kuhn 1955]; O(rows² · columns).
///
/// `cost` has `rows` × `columns` entries, with at least as many columns as rows.
fn cheapest(rows: usize, columns: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    // Row and column 0 stand for none.
    let (mut row_price, mut column_price) = (vec![0.0; rows + 1], vec![0.0; columns + 1]);
    let mut row_of = vec![0; columns + 1];
    for row in 1..=rows {
        row_of[0] = row;
        let mut least = vec![f64::INFINITY; columns + 1];
        let mut before = vec![0; columns + 1];
        let mut is_used = vec![false; columns + 1];
        let mut column = 0;
        // Columns are reached in the order of their reduced cost, until a free one.
        while row_of[column] != 0 {
            is_used[column] = true;
            let from = row_of[column];
            let (mut step, mut next) = (f64::INFINITY, 0);
            for c in (1..=columns).filter(|&c| !is_used[c]) {
                let reduced = cost(from - 1, c - 1) - row_price[from] - column_price[c];
                if reduced < least[c] {
                    (least[c], before[c]) = (reduced, column);
                }
                if least[c] < step {
                    (step, next) = (least[c], c);
                }
            }
            for c in 0..=columns {
                if is_used[c] {
                    row_price[row_of[c]] += step;
                    column_price[c] -= step;
                } else {
                    least[c] -= step;
                }
            }
            column = next;
        }
        while column != 0 {
            row_of[column] = row_of[before[column]];
            column = before[column];
        }
    }
    let mut column_of = vec![0; rows];
    (1..=columns).filter(|&c| row_of[c] != 0).for_each(|c| column_of[row_of[c] - 1] = c - 1);
    column_of
}

/// The pairs of a row and a column that cost least in sum, where a row or column without partner costs `limit`; ascending by row. No
/// pair costs `limit` or more.
pub fn assign(rows: usize, columns: usize, limit: f64, cost: impl Fn(usize, usize) -> f64) -> Vec<(usize, usize)> {
    // A further column a row stands for no partner.
    let padded = |r: usize, c: usize| if c < columns { cost(r, c).min(limit) } else { limit };
    let column_of = cheapest(rows, columns + rows, padded);
    column_of.into_iter().enumerate().filter(|&(r, c)| c < columns && cost(r, c) < limit).collect()
}

#[cfg(test)]
mod tests {
    use mimesh_core::random::Random;

    use super::*;

    #[test]
    fn the_sum_is_that_of_the_best_of_all_pairings() {
        let mut random = Random::new(3);
        for (rows, columns) in [(1, 1), (3, 3), (4, 6), (5, 5), (6, 6)] {
            let costs: Vec<Vec<f64>> =
                (0..rows).map(|_| (0..columns).map(|_| random.between(0.0, 1.0)).collect()).collect();
            let found = cheapest(rows, columns, |r, c| costs[r][c]);
            let sum: f64 = found.iter().enumerate().map(|(r, &c)| costs[r][c]).sum();
            // Sums of up to six numbers in another order differ by rounding.
            assert!((sum - best(&costs, &mut vec![false; columns])).abs() < 1e-12);
        }
    }

    /// The least sum, by trying all.
    fn best(costs: &[Vec<f64>], used: &mut Vec<bool>) -> f64 {
        let Some((first, rest)) = costs.split_first() else { return 0.0 };
        let mut least = f64::INFINITY;
        for c in 0..used.len() {
            if !used[c] {
                used[c] = true;
                least = least.min(first[c] + best(rest, used));
                used[c] = false;
            }
        }
        least
    }

    #[test]
    fn what_costs_too_much_has_no_partner() {
        let costs = [[0.1, 0.9], [0.2, 5.0], [0.3, 0.2]];
        assert_eq!(assign(3, 2, 0.6, |r, c| costs[r][c]), [(0, 0), (2, 1)]);
        assert_eq!(assign(0, 2, 0.6, |_, _| 0.0), []);
        assert_eq!(assign(2, 0, 0.6, |_, _| 0.0), []);
    }
}
