//! The rotations of matrices by Newton's iteration, several at once.

use pulp::{Arch, NullaryFnOnce};

/// How many matrices are turned at once.
pub(super) const LANES: usize = 8;

/// Nine entries by columns, of a matrix a lane.
pub(super) type Entries<const N: usize> = [[f64; N]; 9];

/// The rotations nearest to `N` matrices, and which of them were found: a matrix must be far from singular and no reflection, since
/// the iteration keeps the sign of the determinant.
///
/// Scaled Newton iteration (Higham 1986), which doubles its digits a step. The result of a lane does not depend on the others.
pub(super) fn newton<const N: usize>(f: &Entries<N>) -> (Entries<N>, [bool; N]) {
    // One matrix has nothing to gain by vectors.
    if N == 1 { Newton(f).call() } else { Arch::new().dispatch(Newton(f)) }
}

struct Newton<'a, const N: usize>(&'a Entries<N>);

// Inlined into the function that the processor's instructions are chosen for.
impl<const N: usize> NullaryFnOnce for Newton<'_, N> {
    type Output = (Entries<N>, [bool; N]);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let mut r = *self.0;
        let size = norm(&r);
        for entry in &mut r {
            for k in 0..N {
                entry[k] /= size[k];
            }
        }
        let (mut found, mut is_found) = ([[0.0; N]; 9], [false; N]);
        let is_sound = determinant(&r, &cofactors(&r)).map(|determinant| determinant > 1e-6);
        for _ in 0..20 {
            if (0..N).all(|k| is_found[k] || !is_sound[k]) {
                break;
            }
            let next = step(&r, true);
            let mut change = [[0.0; N]; 9];
            for e in 0..9 {
                for k in 0..N {
                    change[e][k] = next[e][k] - r[e][k];
                }
            }
            r = next;
            let change = norm(&change);
            if (0..N).any(|k| change[k] < 1e-9 && !is_found[k]) {
                // One more unscaled step takes the remaining error, now squared, to rounding.
                let last = step(&r, false);
                for k in 0..N {
                    if change[k] < 1e-9 && !is_found[k] {
                        (0..9).for_each(|e| found[e][k] = last[e][k]);
                        is_found[k] = is_sound[k];
                    }
                }
            }
        }
        (found, is_found)
    }
}

/// The mean of r and r⁻ᵀ, scaled towards each other or not.
#[inline(always)]
fn step<const N: usize>(r: &Entries<N>, is_scaled: bool) -> Entries<N> {
    let mut inverse = cofactors(r);
    // Factors take the place of divisions, which last longer.
    let factor = determinant(r, &inverse).map(|determinant| 1.0 / determinant);
    for entry in &mut inverse {
        for k in 0..N {
            entry[k] *= factor[k];
        }
    }
    let mut shares = [[0.5; N]; 2];
    if is_scaled {
        let (of_inverse, of_r) = (norm(&inverse), norm(r));
        for k in 0..N {
            let scale = (of_inverse[k] / of_r[k]).sqrt();
            (shares[0][k], shares[1][k]) = (0.5 * scale, 0.5 / scale);
        }
    }
    let mut next = [[0.0; N]; 9];
    for e in 0..9 {
        for k in 0..N {
            next[e][k] = r[e][k] * shares[0][k] + inverse[e][k] * shares[1][k];
        }
    }
    next
}

/// det(F) F⁻ᵀ.
#[inline(always)]
fn cofactors<const N: usize>(f: &Entries<N>) -> Entries<N> {
    let mut cofactors = [[0.0; N]; 9];
    for column in 0..3 {
        let (a, b) = (3 * ((column + 1) % 3), 3 * ((column + 2) % 3));
        for row in 0..3 {
            let (i, j) = ((row + 1) % 3, (row + 2) % 3);
            for k in 0..N {
                cofactors[3 * column + row][k] = f[a + i][k] * f[b + j][k] - f[a + j][k] * f[b + i][k];
            }
        }
    }
    cofactors
}

#[inline(always)]
fn determinant<const N: usize>(f: &Entries<N>, cofactors: &Entries<N>) -> [f64; N] {
    std::array::from_fn(|k| f[0][k] * cofactors[0][k] + f[1][k] * cofactors[1][k] + f[2][k] * cofactors[2][k])
}

/// The Frobenius norm.
#[inline(always)]
fn norm<const N: usize>(f: &Entries<N>) -> [f64; N] {
    let mut sum = [0.0; N];
    for entry in f {
        for k in 0..N {
            sum[k] += entry[k] * entry[k];
        }
    }
    sum.map(f64::sqrt)
}
