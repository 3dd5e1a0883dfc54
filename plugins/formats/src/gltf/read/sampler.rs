//! A property that changes over time.

use gltf::json::animation::Interpolation;

/// Keys of a property and what lies between them.
#[derive(Debug)]
pub struct Sampler {
    /// The times of the keys in seconds, never decreasing.
    pub times: Vec<f64>,
    /// The numbers of the keys; of cubic splines in-tangent, value and out-tangent.
    values: Vec<f64>,
    /// Numbers a value.
    width: usize,
    interpolation: Interpolation,
    /// Whether the values are quaternions.
    is_rotation: bool,
}

impl Sampler {
    /// A sampler of values of `width` numbers.
    ///
    /// # Errors
    ///
    /// Says what is wrong with the keys.
    pub fn new(
        times: Vec<f64>,
        values: Vec<f64>,
        width: usize,
        interpolation: Interpolation,
        is_rotation: bool,
    ) -> Result<Self, String> {
        if times.is_empty() || width == 0 {
            return Err("it has no keys".into());
        }
        if !times.iter().chain(&values).all(|x| x.is_finite()) {
            return Err("it has keys that are not finite".into());
        }
        if !times.is_sorted() {
            return Err("its times decrease".into());
        }
        let a_key = if interpolation == Interpolation::CubicSpline { 3 * width } else { width };
        if values.len() < times.len() * a_key {
            return Err(format!("it has {} numbers for {} keys of {a_key}", values.len(), times.len()));
        }
        Ok(Self { times, values, width, interpolation, is_rotation })
    }

    /// The value at `seconds`, that of the first or last key before or after all of them.
    pub fn at(&self, seconds: f64) -> Vec<f64> {
        let next = self.times.partition_point(|&time| time <= seconds);
        if next == 0 || next == self.times.len() {
            return self.finished(self.key(next.saturating_sub(1)).to_vec());
        }
        let (from, span) = (next - 1, self.times[next] - self.times[next - 1]);
        let s = (seconds - self.times[from]) / span;
        let value = match self.interpolation {
            Interpolation::Step => self.key(from).to_vec(),
            Interpolation::Linear if self.is_rotation => return slerp(self.key(from), self.key(next), s),
            Interpolation::Linear => mixed(&[(1.0 - s, self.key(from)), (s, self.key(next))]),
            Interpolation::CubicSpline => {
                // Hermite's polynomials (glTF 2.0, appendix C.4); tangents are per second.
                let (s2, s3) = (s * s, s * s * s);
                mixed(&[
                    (2.0 * s3 - 3.0 * s2 + 1.0, self.key(from)),
                    (span * (s3 - 2.0 * s2 + s), self.numbers(3 * from + 2)),
                    (3.0 * s2 - 2.0 * s3, self.key(next)),
                    (span * (s3 - s2), self.numbers(3 * next)),
                ])
            }
        };
        self.finished(value)
    }

    /// The value of a key.
    fn key(&self, key: usize) -> &[f64] {
        self.numbers(if self.interpolation == Interpolation::CubicSpline { 3 * key + 1 } else { key })
    }

    fn numbers(&self, entry: usize) -> &[f64] {
        &self.values[entry * self.width..(entry + 1) * self.width]
    }

    fn finished(&self, value: Vec<f64>) -> Vec<f64> {
        if self.is_rotation { normalized(&value) } else { value }
    }
}

/// The sum of values times factors.
fn mixed(terms: &[(f64, &[f64])]) -> Vec<f64> {
    let width = terms.first().map_or(0, |(_, value)| value.len());
    (0..width).map(|i| terms.iter().map(|(factor, value)| factor * value[i]).sum()).collect()
}

/// The quaternion with unit length; one of no length is no rotation.
fn normalized(quaternion: &[f64]) -> Vec<f64> {
    let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { quaternion.iter().map(|x| x / length).collect() } else { vec![0.0, 0.0, 0.0, 1.0] }
}

/// The rotation at `s` (0 to 1) of the shortest way from `a` to `b`, with constant speed.
fn slerp(a: &[f64], b: &[f64], s: f64) -> Vec<f64> {
    let (a, mut b) = (normalized(a), normalized(b));
    let mut cosine: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    if cosine < 0.0 {
        b.iter_mut().for_each(|x| *x = -*x);
        cosine = -cosine;
    }
    let angle = cosine.min(1.0).acos();
    // So close, the chord is the arc to the last bit, and the sine is too small to divide by.
    if angle < 1e-7 {
        return normalized(&mixed(&[(1.0 - s, &a), (s, &b)]));
    }
    normalized(&mixed(&[(((1.0 - s) * angle).sin() / angle.sin(), &a), ((s * angle).sin() / angle.sin(), &b)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampler(times: &[f64], values: &[f64], width: usize, interpolation: Interpolation) -> Sampler {
        Sampler::new(times.to_vec(), values.to_vec(), width, interpolation, width == 4).unwrap()
    }

    #[test]
    fn lines_and_steps_run_between_keys_and_stop_at_the_ends() {
        let line = sampler(&[1.0, 3.0], &[0.0, 4.0], 1, Interpolation::Linear);
        assert_eq!([0.0, 1.0, 1.5, 3.0, 9.0].map(|time| line.at(time)[0]), [0.0, 0.0, 1.0, 4.0, 4.0]);
        let steps = sampler(&[1.0, 3.0], &[0.0, 4.0], 1, Interpolation::Step);
        assert_eq!([0.0, 2.999, 3.0].map(|time| steps.at(time)[0]), [0.0, 0.0, 4.0]);
    }

    #[test]
    fn two_keys_at_one_time_are_a_jump() {
        let jump = sampler(&[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 5.0, 6.0], 1, Interpolation::Linear);
        assert_eq!([0.5, 1.0, 1.5].map(|time| jump.at(time)[0]), [0.5, 5.0, 5.5]);
    }

    #[test]
    fn splines_follow_cubic_polynomials() {
        // x = t³ from 1 to 3, with its derivative 3 t² as tangents.
        let spline = sampler(&[1.0, 3.0], &[0.0, 1.0, 3.0, 27.0, 27.0, 0.0], 1, Interpolation::CubicSpline);
        for time in [1.0, 1.25, 2.0, 2.9, 3.0] {
            assert!((spline.at(time)[0] - f64::powi(time, 3)).abs() < 1e-13);
        }
    }

    #[test]
    fn rotations_turn_evenly_and_the_shortest_way() {
        let half = 0.5_f64.sqrt();
        // A quarter turn about x; its negative is the same rotation.
        for sign in [1.0, -1.0] {
            let turn = sampler(
                &[0.0, 1.0],
                &[0.0, 0.0, 0.0, 1.0, sign * half, 0.0, 0.0, sign * half],
                4,
                Interpolation::Linear,
            );
            let eighth = std::f64::consts::FRAC_PI_8 / 2.0;
            let [x, y, z, w] = turn.at(0.25)[..] else { unreachable!() };
            assert!((x - eighth.sin()).abs() + y.abs() + z.abs() + (w - eighth.cos()).abs() < 1e-15);
        }
        let none = sampler(&[0.0, 1.0], &[0.0; 8], 4, Interpolation::Linear);
        assert_eq!(none.at(0.5), [0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn keys_that_are_no_such_are_refused() {
        let new = |times: &[f64], values: &[f64]| {
            Sampler::new(times.to_vec(), values.to_vec(), 1, Interpolation::Linear, false).unwrap_err()
        };
        assert_eq!(new(&[], &[]), "it has no keys");
        assert_eq!(new(&[0.0, f64::NAN], &[0.0, 1.0]), "it has keys that are not finite");
        assert_eq!(new(&[1.0, 0.0], &[0.0, 1.0]), "its times decrease");
        assert_eq!(new(&[0.0, 1.0], &[0.0]), "it has 1 numbers for 2 keys of 1");
    }
}
