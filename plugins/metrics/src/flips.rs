//! Which triangles of a surface are folded over against their neighbours.

use mimesh_core::{mesh::Surface, operators::rotations};
use nalgebra::{Matrix3, Point3, Vector3};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// A surface at rest.
pub struct Rest<'a> {
    triangles: &'a [[u32; 3]],
    vertex_count: usize,
    /// What each triangle brings into Σ e′eᵀ + 2√(A′A) n′nᵀ; `None` without area.
    frames: Vec<Option<Frame>>,
    /// Whether each triangle is wide enough to lose its area.
    is_wide: Vec<bool>,
    /// Twice the area of all triangles.
    area: f64,
}

/// A triangle at rest, with its edges u and v from the first corner.
///
/// Over its three edges Σ e′eᵀ = u′ (2u − v)ᵀ + v′ (2v − u)ᵀ.
struct Frame {
    /// 2u − v and 2v − u.
    edges: [Vector3<f64>; 2],
    /// The unit normal.
    normal: Vector3<f64>,
    /// Twice the area.
    area: f64,
}

/// A triangle in a pose.
pub struct Posed {
    edges: [Vector3<f64>; 2],
    /// u′ × v′, as long as twice the area.
    normal: Vector3<f64>,
}

impl Posed {
    fn new([a, b, c]: [Point3<f64>; 3]) -> Self {
        let (u, v) = (b - a, c - a);
        Self { edges: [u, v], normal: u.cross(&v) }
    }

    /// Twice the area; `None` if there is none, or it is not finite.
    fn area(&self) -> Option<f64> {
        let area = self.normal.norm();
        (area.is_finite() && area > 0.0).then_some(area)
    }

    /// The height over the longest edge, relative to that edge.
    fn relative_height(&self) -> f64 {
        let [u, v] = &self.edges;
        let longest = u.norm_squared().max(v.norm_squared()).max((v - u).norm_squared());
        if longest == 0.0 { 0.0 } else { self.normal.norm() / longest }
    }
}

impl<'a> Rest<'a> {
    pub fn new(surface: &'a Surface) -> Self {
        let rest: Vec<Posed> = corners(&surface.triangles, &surface.positions).map(Posed::new).collect();
        let frame = |triangle: &Posed| {
            let ([u, v], area) = (triangle.edges, triangle.area()?);
            Some(Frame { edges: [2.0 * u - v, 2.0 * v - u], normal: triangle.normal / area, area })
        };
        let frames: Vec<Option<Frame>> = rest.iter().map(frame).collect();
        Self {
            triangles: &surface.triangles,
            vertex_count: surface.vertex_count(),
            area: frames.iter().flatten().map(|frame| frame.area).sum(),
            frames,
            is_wide: rest.iter().map(|triangle| triangle.relative_height() > 1e-4).collect(),
        }
    }

    /// The triangles at `positions`.
    pub fn posed(&self, positions: &[Point3<f64>]) -> Vec<Posed> {
        corners(self.triangles, positions).map(Posed::new).collect()
    }

    /// Whether each triangle is flipped in a pose.
    pub fn flipped(&self, posed: &[Posed]) -> Vec<bool> {
        let mut rings = vec![[[0.0; 4]; 3]; self.vertex_count];
        Arch::new().dispatch(AddTerms { rest: self, posed, rings: &mut rings });
        let is_flipped = |(chunk, posed): (usize, &[Posed])| {
            Arch::new().dispatch(Flipped { rest: self, first: chunk * CHUNK, posed, rings: &rings })
        };
        posed.par_chunks(CHUNK).enumerate().flat_map_iter(is_flipped).collect()
    }

    /// The area at rest of flipped triangles, in percent of all.
    pub fn share(&self, flipped: &[bool]) -> f64 {
        let areas = self.frames.iter().zip(flipped).filter(|(_, flipped)| **flipped);
        let sum = areas.filter_map(|(frame, _)| Some(frame.as_ref()?.area)).fold(0.0, |sum, area| sum + area);
        if self.area > 0.0 { 100.0 * sum / self.area } else { 0.0 }
    }

    /// The number of triangles that have an area at rest and none in the pose.
    pub fn degenerate_count(&self, posed: &[Posed]) -> usize {
        let is_degenerate = |(posed, is_wide): (&Posed, &bool)| posed.relative_height() < 1e-6 && *is_wide;
        posed.iter().zip(&self.is_wide).map(is_degenerate).filter(|is_degenerate| *is_degenerate).count()
    }
}

/// A 3 × 3 matrix by columns, each filled up to a vector of the processor.
type Columns = [[f64; 4]; 3];

/// Triangles that are looked at together.
const CHUNK: usize = 1024;

/// Adds what each triangle brings to the sums at its vertices.
struct AddTerms<'a> {
    rest: &'a Rest<'a>,
    posed: &'a [Posed],
    rings: &'a mut [Columns],
}

// Inlined into the function that the processor's instructions are chosen for.
impl NullaryFnOnce for AddTerms<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { rest, posed, rings } = self;
        for ((rest, now), corners) in rest.frames.iter().zip(posed).zip(rest.triangles) {
            let Some((rest, area)) = rest.as_ref().zip(now.area()) else { continue };
            let now = [now.edges[0], now.edges[1], now.normal * (rest.area / area).sqrt()].map(filled);
            let rest = [rest.edges[0], rest.edges[1], rest.normal];
            let term: Columns = std::array::from_fn(|column| {
                std::array::from_fn(|row| {
                    now[0][row] * rest[0][column] + now[1][row] * rest[1][column] + now[2][row] * rest[2][column]
                })
            });
            corners.iter().for_each(|&v| add(&mut rings[v as usize], &term));
        }
    }
}

/// Whether each triangle is flipped, from number `first` on.
struct Flipped<'a> {
    rest: &'a Rest<'a>,
    first: usize,
    posed: &'a [Posed],
    rings: &'a [Columns],
}

impl NullaryFnOnce for Flipped<'_> {
    type Output = Vec<bool>;

    #[inline(always)]
    fn call(self) -> Vec<bool> {
        let Self { rest, first, posed, rings } = self;
        let mut flipped = vec![false; posed.len()];
        let (mut open, mut sums) = (Vec::new(), Vec::new());
        for (place, now) in posed.iter().enumerate() {
            let Some((frame, _)) = rest.frames[first + place].as_ref().zip(now.area()) else { continue };
            let [a, b, c] = rest.triangles[first + place].map(|v| &rings[v as usize]);
            let mut sum = *a;
            add(&mut sum, b);
            add(&mut sum, c);
            let sum = Matrix3::from_fn(|row, column| sum[column][row]);
            match points_backwards(&sum, &frame.normal, &now.normal) {
                Some(points_backwards) => flipped[place] = points_backwards,
                None => {
                    open.push((place, frame.normal));
                    sums.push(sum);
                }
            }
        }
        for ((place, normal), turn) in open.into_iter().zip(rotations(&sums)) {
            flipped[place] = posed[place].normal.dot(&(turn * normal)) < 0.0;
        }
        flipped
    }
}

#[inline(always)]
fn filled(vector: Vector3<f64>) -> [f64; 4] {
    [vector.x, vector.y, vector.z, 0.0]
}

#[inline(always)]
fn add(to: &mut Columns, term: &Columns) {
    to.iter_mut().zip(term).for_each(|(to, term)| (0..4).for_each(|row| to[row] += term[row]));
}

/// The corners of each triangle.
fn corners(triangles: &[[u32; 3]], positions: &[Point3<f64>]) -> impl Iterator<Item = [Point3<f64>; 3]> {
    triangles.iter().map(|t| t.map(|v| positions[v as usize]))
}

/// Whether m · R n < 0 for the rotation R nearest to F, where that is certain without R.
///
/// With F = R S, one scaled step of Newton's iteration for R gives a matrix along R S₁, where the eigenvalues of S₁ are 1 at least. By the
/// Frobenius norm they are k at most, k² = (p − 1) / 2 with p = ‖F‖ ‖cof F‖ / det F. So S₁ turns no vector by more than an angle of
/// sine (k − 1) / (k + 1), and R n lies that near to y = cof F n + F n ‖cof F‖ / ‖F‖.
#[inline(always)]
fn points_backwards(f: &Matrix3<f64>, n: &Vector3<f64>, m: &Vector3<f64>) -> Option<bool> {
    let [a, b, c] = [0, 1, 2].map(|k| f.column(k));
    let cofactors = Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)]);
    let determinant = a.dot(&cofactors.column(0));
    let [size, cofactor_size] = [f.norm(), cofactors.norm()];
    // Nearly singular, or a reflection.
    if determinant.is_nan() || determinant <= MIN_DETERMINANT * size.powi(3) {
        return None;
    }
    let p = size * cofactor_size / determinant;
    let k = ((p - 1.0) / 2.0).max(1.0).sqrt();
    let y = cofactors * n + f * n * (cofactor_size / size);
    let product = m.dot(&y);
    let is_certain = product.abs() > ((k - 1.0) / (k + 1.0) + ROUNDING) * m.norm() * y.norm();
    is_certain.then_some(product < 0.0)
}

/// The smallest determinant of a sum of norm 1 that a certain answer is given for.
const MIN_DETERMINANT: f64 = 1e-6;

/// What the sine of an angle is off by, with the digits that such a determinant leaves.
const ROUNDING: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use mimesh_core::{operators::polar, testkit::random::Random};

    use super::*;

    #[test]
    fn what_is_certain_is_what_the_rotation_says() {
        let mut random = Random::new(11);
        let (mut certain, mut backwards) = (0, 0);
        for i in 0..20_000 {
            let columns = [(); 3].map(|()| random.vector());
            // From nearly a rotation to nearly flat.
            let stretch = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 10f64.powi(-(i % 5))));
            let f = polar(&Matrix3::from_columns(&columns)).rotation * stretch + 0.1 * Matrix3::from_columns(&columns);
            let (n, m) = (random.vector().normalize(), random.vector());
            let expected = m.dot(&(rotations(&[f])[0] * n)) < 0.0;
            if let Some(found) = points_backwards(&f, &n, &m) {
                assert_eq!(found, expected, "{f} {n} {m}");
                certain += 1;
                backwards += usize::from(found);
            }
        }
        // Directions are random: of the better half most are certain, and as many point either way.
        assert!(certain > 8_000 && backwards > certain / 3 && backwards < certain * 2 / 3, "{certain} {backwards}");
    }

    #[test]
    fn reflections_and_flat_sums_are_left_open() {
        let n = Vector3::z();
        for diagonal in [Vector3::new(1.0, 1.0, -1.0), Vector3::new(1.0, 1.0, 0.0), Vector3::zeros()] {
            assert_eq!(points_backwards(&Matrix3::from_diagonal(&diagonal), &n, &n), None);
        }
    }
}
