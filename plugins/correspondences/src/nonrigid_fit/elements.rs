use mimesh_core::{
    Result,
    linalg::{Assembly, FixedUnknowns},
    mesh::{Surface, SurfacePoint},
    operators::{is_degenerate, voronoi_mass},
    stage::Pair,
};
use nalgebra::{Matrix3, Point3};

use super::{NonrigidFit, UnitFrame};

/// How strongly a marker inside a target triangle is held, relative to `smoothness`; markers at vertices are exact.
const MARKER_WEIGHT: f64 = 1e6;

/// How strongly the vertices of triangles without area are tied to each other, so that they follow their neighbours.
const DEGENERATE_WEIGHT: f64 = 1e-3;

/// The triangles of the target with their fourth vertices, each a tetrahedron with a constant deformation gradient.
pub struct Elements<'a> {
    surface: &'a Surface,
    elements: Vec<Option<Element>>,
    unknowns: usize,
    mass: Vec<f64>,
}

/// F = Σ xᵢ gᵢᵀ over four unknowns.
struct Element {
    unknowns: [u32; 4],
    gradient: [[f64; 3]; 4],
}

impl<'a> Elements<'a> {
    /// The elements of `surface` with its vertices at `rest`; vertices come first, then a fourth vertex a triangle.
    pub fn new(rest: &[Point3<f64>], surface: &'a Surface) -> Self {
        let mut unknowns = rest.len();
        let elements = surface
            .triangles
            .iter()
            .map(|&[a, b, c]| {
                let corners = [a, b, c].map(|v| rest[v as usize]);
                if is_degenerate(&corners) {
                    return None;
                }
                unknowns += 1;
                Some(Element { unknowns: [a, b, c, unknowns as u32 - 1], gradient: gradient(&corners) })
            })
            .collect();
        let mass = voronoi_mass(rest, &surface.triangles);
        Self { surface, elements, unknowns, mass }
    }

    /// The energy without closest points, ready to be minimised.
    pub fn system(&self, settings: &NonrigidFit, pair: Pair<'_>, unit: &UnitFrame) -> Result<System> {
        let n = self.unknowns;
        let mut assembly = Assembly::new(n);
        let mut rhs = vec![0.0; 3 * n];
        for element in self.elements.iter().flatten() {
            assembly.add_outer(&element.unknowns, &element.gradient, settings.identity);
            for (&i, g) in element.unknowns.iter().zip(&element.gradient) {
                (0..3).for_each(|c| rhs[c * n + i as usize] += settings.identity * g[c]);
            }
        }
        for [a, b] in self.surface.topology().adjacent {
            if let (Some(a), Some(b)) = (&self.elements[a as usize], &self.elements[b as usize]) {
                let indices: Vec<u32> = a.unknowns.into_iter().chain(b.unknowns).collect();
                let minus = b.gradient.map(|g| g.map(|x| -x));
                let rows: Vec<[f64; 3]> = a.gradient.into_iter().chain(minus).collect();
                assembly.add_outer(&indices, &rows, settings.smoothness);
            }
        }
        for (t, _) in self.surface.triangles.iter().zip(&self.elements).filter(|(_, e)| e.is_none()) {
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                if t[i] != t[j] {
                    assembly.add_outer(&[t[i], t[j]], &[[1.0], [-1.0]], DEGENERATE_WEIGHT);
                }
            }
        }
        let mut fixed = Vec::new();
        let mut values: [Vec<f64>; 3] = Default::default();
        for marker in pair.markers {
            let at = marker.source.position(pair.source, &unit.source);
            match marker.target {
                SurfacePoint::Vertex(vertex) => {
                    fixed.push(vertex);
                    (0..3).for_each(|c| values[c].push(at[c]));
                }
                SurfacePoint::Triangle(triangle, barycentric) => {
                    let corners = self.surface.triangles[triangle as usize];
                    let weight = MARKER_WEIGHT * settings.smoothness.max(settings.identity);
                    assembly.add_outer(&corners, &barycentric.map(|b| [b]), weight);
                    for (&v, b) in corners.iter().zip(barycentric) {
                        (0..3).for_each(|c| rhs[c * n + v as usize] += weight * b * at[c]);
                    }
                }
            }
        }
        self.fix_loose(&unit.target, &mut fixed, &mut values);
        let system = FixedUnknowns::new(&assembly.finish(), &fixed, "the fit of the target to the markers")?;
        let total: f64 = self.mass.iter().sum();
        let share = self.mass.iter().map(|m| m / total * self.mass.len() as f64).collect();
        Ok(System {
            added: vec![0.0; system.free_count()],
            system,
            rhs,
            values: values.concat(),
            share,
            weight: 0.0,
            x: vec![],
        })
    }

    /// E_S of the last solution: Σ over adjacent triangles ‖F_a − F_b‖².
    pub fn smoothness_energy(&self, system: &System) -> f64 {
        let at = |unknown: u32, c: usize| system.x[c * self.unknowns + unknown as usize];
        let of =
            |e: &Element| Matrix3::from_fn(|c, j| (0..4).map(|k| at(e.unknowns[k], c) * e.gradient[k][j]).sum::<f64>());
        let squares = self.surface.topology().adjacent.into_iter().filter_map(|[a, b]| {
            let (a, b) = (self.elements[a as usize].as_ref()?, self.elements[b as usize].as_ref()?);
            Some((of(a) - of(b)).norm_squared())
        });
        squares.sum()
    }

    /// Holds vertices that no triangle uses where they are: nothing else would.
    fn fix_loose(&self, rest: &[Point3<f64>], fixed: &mut Vec<u32>, values: &mut [Vec<f64>; 3]) {
        let mut used = vec![false; rest.len()];
        self.surface.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        fixed.iter().for_each(|&v| used[v as usize] = true);
        for v in (0..rest.len()).filter(|&v| !used[v]) {
            fixed.push(v as u32);
            (0..3).for_each(|c| values[c].push(rest[v][c]));
        }
    }
}

/// The quadratic energy with its markers.
pub struct System {
    system: FixedUnknowns,
    /// b without closest points, n × 3 by columns.
    rhs: Vec<f64>,
    /// Positions of fixed unknowns, by columns.
    values: Vec<f64>,
    /// What closest points have added to the diagonal.
    added: Vec<f64>,
    /// Area of each vertex relative to the mean.
    share: Vec<f64>,
    weight: f64,
    /// All unknowns of the last solution, by columns.
    x: Vec<f64>,
}

impl System {
    /// Changes E_C: its weight and which vertices have a closest point.
    pub fn attract(&mut self, weight: f64, points: &[Option<Point3<f64>>]) -> Result<()> {
        self.weight = weight;
        let share = &self.share;
        let pull = |i: usize| if points.get(i).is_some_and(Option::is_some) { weight * share[i] } else { 0.0 };
        self.system.set_diagonal(&mut self.added, pull)
    }

    /// The deformed vertices, #V; `points` as in the last [`attract`](Self::attract), or empty.
    pub fn solve(&mut self, points: &[Option<Point3<f64>>]) -> Vec<Point3<f64>> {
        let n = self.rhs.len() / 3;
        let mut rhs = self.rhs.clone();
        for (i, point) in points.iter().enumerate() {
            if let Some(point) = point {
                (0..3).for_each(|c| rhs[c * n + i] += self.weight * self.share[i] * point[c]);
            }
        }
        self.x = self.system.solve(&rhs, &self.values, 3);
        let x = &self.x;
        (0..self.share.len()).map(|i| Point3::new(x[i], x[n + i], x[2 * n + i])).collect()
    }
}

/// The vectors gᵢ of the tetrahedron over `corners` whose fourth vertex stands on the first corner along the normal, at
/// the square root of twice the area.
fn gradient(&[a, b, c]: &[Point3<f64>; 3]) -> [[f64; 3]; 4] {
    let normal = (b - a).cross(&(c - a));
    let frame = Matrix3::from_columns(&[b - a, c - a, normal / normal.norm().sqrt()]);
    // The caller has made sure that the triangle has an area.
    let inverse = frame.try_inverse().unwrap_or_default();
    let row = |k: usize| [inverse[(k, 0)], inverse[(k, 1)], inverse[(k, 2)]];
    let first = std::array::from_fn(|j| -(0..3).map(|k| inverse[(k, j)]).sum::<f64>());
    [first, row(0), row(1), row(2)]
}
