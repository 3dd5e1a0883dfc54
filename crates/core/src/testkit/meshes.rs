//! Small generated meshes: known shapes, and the defects that files bring.
//!
//! Shapes that stages compute on come as [`Surface`]; those that are about files (seams, stray vertices) as [`Mesh`].
//! Triangles run counter-clockwise seen from outside, so closed shapes have positive volume.

use std::{collections::BTreeMap, f64::consts::PI};

use nalgebra::{Point3, Vector3};

use crate::mesh::{CornerAttribute, Mesh, Surface};

/// The regular tetrahedron inscribed in the unit sphere: 4 vertices, 4 triangles.
pub fn tetrahedron() -> Surface {
    let corners = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]];
    let positions = corners.map(|c| Point3::from(Vector3::from(c).normalize())).to_vec();
    surface(positions, vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
}

/// The unit sphere: an icosahedron cut `level` times into four, 10·4ˡ + 2 vertices, 20·4ˡ triangles.
pub fn icosphere(level: usize) -> Surface {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut positions: Vec<_> = [
        [-1., golden, 0.],
        [1., golden, 0.],
        [-1., -golden, 0.],
        [1., -golden, 0.],
        [0., -1., golden],
        [0., 1., golden],
        [0., -1., -golden],
        [0., 1., -golden],
        [golden, 0., -1.],
        [golden, 0., 1.],
        [-golden, 0., -1.],
        [-golden, 0., 1.],
    ]
    .map(|c| Point3::from(Vector3::from(c).normalize()))
    .to_vec();
    let mut triangles = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level {
        triangles = quarter(&mut positions, &triangles);
    }
    surface(positions, triangles)
}

/// The unit square at z = 0, normal +z, in `nx` × `ny` cells of two triangles: (nx + 1)·(ny + 1) vertices, row by
/// row in y.
pub fn grid(nx: usize, ny: usize) -> Surface {
    let row = nx as u32 + 1;
    let (x, y) = (|i: usize| i as f64 / nx as f64, |j: usize| j as f64 / ny as f64);
    let positions = (0..=ny).flat_map(|j| (0..=nx).map(move |i| Point3::new(x(i), y(j), 0.0))).collect();
    let cells = (0..ny as u32).flat_map(|j| (0..nx as u32).map(move |i| j * row + i));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]).collect();
    surface(positions, triangles)
}

/// A closed box of edge lengths `size` about the origin, its faces cut into `cells` along x, y and z.
pub fn bar(cells: [usize; 3], size: [f64; 3]) -> Surface {
    let mut numbers = BTreeMap::new();
    let mut positions = Vec::new();
    let mut vertex = |lattice: [usize; 3]| {
        *numbers.entry(lattice).or_insert_with(|| {
            let x = |k: usize| size[k] * (lattice[k] as f64 / cells[k] as f64 - 0.5);
            positions.push(Point3::new(x(0), x(1), x(2)));
            positions.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (level, outward) in [(0, false), (cells[axis], true)] {
            for (i, j) in (0..cells[u]).flat_map(|i| (0..cells[v]).map(move |j| (i, j))) {
                let [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| {
                    let mut lattice = [level; 3];
                    (lattice[u], lattice[v]) = (i, j);
                    vertex(lattice)
                });
                triangles.extend(if outward { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    surface(positions, triangles)
}

/// A closed cylinder about the y axis, of radius 1 from y = 0 to `height`: `around` × `along` quads and a fan on
/// each end.
pub fn cylinder(around: usize, along: usize, height: f64) -> Surface {
    let rings = (0..=along).map(|ring| (1.0, height * ring as f64 / along as f64)).collect::<Vec<_>>();
    revolve(around, &rings, 0.0, height)
}

/// A capsule about the y axis: hemispheres of radius 1 about y = 0 and y = `height`, joined by `along` rings of quads.
pub fn capsule(around: usize, along: usize, height: f64) -> Surface {
    let bands = (around / 4).max(2);
    let angle = |band: usize| PI / 2.0 * band as f64 / bands as f64;
    let bottom = (1..=bands).map(|band| (angle(band).sin(), -angle(band).cos()));
    let wall = (1..along).map(|ring| (1.0, height * ring as f64 / along as f64));
    let top = (1..=bands).rev().map(|band| (angle(band).sin(), height + angle(band).cos()));
    let rings: Vec<_> = bottom.chain(wall).chain(top).collect();
    revolve(around, &rings, -1.0, height + 1.0)
}

/// An animal of blocks: a trunk along z with four legs down y, a neck up and forward, and a head; `[legs, neck, head]` are the lengths
/// of these limbs, in widths of a leg. Squares of a third of a leg's width, two triangles each.
pub fn blocky_animal([legs, neck, head]: [i32; 3]) -> Surface {
    const FINE: i32 = 3;
    let mut blocks = vec![([0, legs, 0], [3, legs + 2, 7])];
    blocks.extend([0, 2].into_iter().flat_map(|x| [0, 6].map(|z| ([x, 0, z], [x + 1, legs, z + 1]))));
    blocks.push(([1, legs + 2, 6], [2, legs + 2 + neck, 7]));
    blocks.push(([1, legs + 1 + neck, 7], [2, legs + 2 + neck, 7 + head]));
    let is_filled = |cell: [i32; 3]| {
        let cell = cell.map(|c| c.div_euclid(FINE));
        blocks.iter().any(|(low, high)| (0..3).all(|k| (low[k]..high[k]).contains(&cell[k])))
    };
    let extent = [3, legs + 2 + neck, 7 + head].map(|e| FINE * e);
    let mut numbers = BTreeMap::new();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let cells = (0..extent[0]).flat_map(|x| (0..extent[1]).flat_map(move |y| (0..extent[2]).map(move |z| [x, y, z])));
    for cell in cells.filter(|cell| is_filled(*cell)) {
        for (axis, up) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let mut beside = cell;
            beside[axis] += if up { 1 } else { -1 };
            if is_filled(beside) {
                continue;
            }
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| {
                let mut corner = cell;
                corner[axis] += i32::from(up);
                corner[u] += i;
                corner[v] += j;
                *numbers.entry(corner).or_insert_with(|| {
                    positions.push(Point3::from(corner.map(f64::from)) / f64::from(FINE));
                    positions.len() as u32 - 1
                })
            });
            triangles.extend(if up { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    surface(positions, triangles)
}

/// Two unit spheres, the second moved by 3 along x: two components of equal size, vertices of the first first.
pub fn two_components() -> Surface {
    let sphere = icosphere(1);
    let count = sphere.vertex_count() as u32;
    let moved = sphere.positions.iter().map(|p| p + 3.0 * Vector3::x());
    let positions = sphere.positions.iter().copied().chain(moved).collect();
    let again = sphere.triangles.iter().map(|t| t.map(|v| v + count));
    let triangles = sphere.triangles.iter().copied().chain(again).collect();
    surface(positions, triangles)
}

/// A sphere of `rings` × `sectors` quads, cut into triangles and stretched by 1, 2 and 3. It is exactly symmetric across x = 0.
pub fn ellipsoid(rings: usize, sectors: usize) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let mut positions = vec![Point3::new(0.0, 0.0, 3.0), Point3::new(0.0, 0.0, -3.0)];
    let half = sectors / 2;
    for ring in 1..rings {
        let polar = std::f64::consts::PI * ring as f64 / rings as f64;
        for sector in 0..sectors {
            // One half is computed, the other its mirror image, so that symmetry holds to the last bit.
            let (k, sign) = if sector < half { (sector, 1.0) } else { (sectors - 1 - sector, -1.0) };
            let angle = std::f64::consts::PI * (k as f64 + 0.5) / half as f64 - std::f64::consts::FRAC_PI_2;
            positions.push(Point3::new(
                sign * polar.sin() * angle.cos(),
                2.0 * polar.sin() * angle.sin(),
                3.0 * polar.cos(),
            ));
        }
    }
    let at = |ring: usize, sector: usize| (2 + (ring - 1) * sectors + sector % sectors) as u32;
    let mut triangles = Vec::new();
    for sector in 0..sectors {
        triangles.push([0, at(1, sector), at(1, sector + 1)]);
        triangles.push([1, at(rings - 1, sector + 1), at(rings - 1, sector)]);
        for ring in 1..rings - 1 {
            let [a, b, c, d] = [at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1), at(ring, sector + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions, triangles)
}

/// The wall of a cylinder about the y axis, radius 1, y = 0 to 1, of quads, cut open for its texture along one line.
///
/// (`around` + 1)·(`along` + 1) vertices; those of the first and last column coincide, with texture u = 0 and u = 1.
pub fn seamed_cylinder(around: usize, along: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let mut texture = CornerAttribute::default();
    for ring in 0..=along {
        for column in 0..=around {
            // The last column repeats the first bit by bit.
            let angle = 2.0 * PI * (column % around) as f64 / around as f64;
            let v = ring as f64 / along as f64;
            mesh.positions.push(Point3::new(angle.sin(), v, angle.cos()));
            texture.values.push([column as f64 / around as f64, v]);
        }
    }
    let row = around as u32 + 1;
    for a in (0..along as u32).flat_map(|j| (0..around as u32).map(move |i| j * row + i)) {
        mesh.polygons.push(&[a, a + 1, a + row + 1, a + row]);
    }
    texture.indices = mesh.polygons.corners().iter().map(|&v| Some(v)).collect();
    mesh.texture_coordinates = Some(texture);
    mesh
}

/// A curved sheet of 2 × 2, from x, y = -1 to 1, cut along y = 0: below and above lie `cells` columns of quads from edge to edge,
/// their vertices along the cut at the same places. A mouth: the cut opens between x = -0.5 and 0.5 by [`open_mouth`].
///
/// Vertices of the lower half come first.
pub fn mouth(cells: usize) -> Mesh {
    let (columns, rows) = (cells as u32 + 1, cells as u32 / 2 + 1);
    let mut mesh = Mesh::default();
    for half in 0..2 {
        let start = mesh.positions.len() as u32;
        for (j, i) in (0..rows).flat_map(|j| (0..columns).map(move |i| (j, i))) {
            let x = 2.0 * f64::from(i) / f64::from(columns - 1) - 1.0;
            let y = f64::from(half) - 1.0 + f64::from(j) / f64::from(rows - 1);
            mesh.positions.push(Point3::new(x, y, -0.3 * (x * x + y * y)));
        }
        for a in (0..rows - 1).flat_map(|j| (0..columns - 1).map(move |i| start + j * columns + i)) {
            mesh.polygons.push(&[a, a + 1, a + columns + 1, a + columns]);
        }
    }
    mesh
}

/// [`mouth`] with its lips moved apart by `amount` each at the middle, which fades out towards corners, chin and nose.
pub fn open_mouth(mesh: &Mesh, amount: f64) -> Vec<Point3<f64>> {
    let half = mesh.positions.len() / 2;
    let open = |(v, p): (usize, &Point3<f64>)| {
        let along = (1.0 - 4.0 * p.x * p.x).max(0.0);
        let away = amount * along * (1.0 - p.y.abs()).powi(2);
        *p + Vector3::new(0.0, if v < half { -away } else { away }, 0.0)
    };
    mesh.positions.iter().enumerate().map(open).collect()
}

/// An icosphere with a triangle without area: a new vertex in the middle of an edge of triangle 0 makes the last
/// triangle.
pub fn with_zero_area_triangle() -> Mesh {
    let Surface { mut positions, mut triangles, .. } = icosphere(1);
    let [a, b, _] = triangles[0];
    let middle = positions.len() as u32;
    positions.push(nalgebra::center(&positions[a as usize], &positions[b as usize]));
    triangles.push([a, b, middle]);
    Mesh::from_triangles(positions, &triangles)
}

/// An icosphere whose vertex 0 has a copy at the same place, the last vertex, which triangle 0 uses instead: a slit.
pub fn with_duplicated_vertex() -> Mesh {
    let Surface { mut positions, mut triangles, .. } = icosphere(1);
    let (of, copy) = (triangles[0][0], positions.len() as u32);
    positions.push(positions[of as usize]);
    triangles[0][0] = copy;
    Mesh::from_triangles(positions, &triangles)
}

/// An icosphere with a last vertex, at (0, 2, 0), that no triangle uses.
pub fn with_unreferenced_vertex() -> Mesh {
    let Surface { mut positions, triangles, .. } = icosphere(1);
    positions.push(Point3::new(0.0, 2.0, 0.0));
    Mesh::from_triangles(positions, &triangles)
}

fn surface(positions: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Surface {
    Surface::from_triangles(positions, triangles).expect("generated meshes are valid")
}

/// Cuts triangles into four; new vertices are moved onto the unit sphere.
fn quarter(positions: &mut Vec<Point3<f64>>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let sum = positions[a as usize].coords + positions[b as usize].coords;
            positions.push(Point3::from(sum.normalize()));
            positions.len() as u32 - 1
        })
    };
    let cut = |&[a, b, c]: &[u32; 3]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
    };
    triangles.iter().flat_map(cut).collect()
}

/// The closed surface of revolution about the y axis through `rings` (radius, y), with poles at y = `bottom` and `top`.
fn revolve(around: usize, rings: &[(f64, f64)], bottom: f64, top: f64) -> Surface {
    let mut positions = vec![Point3::new(0.0, bottom, 0.0), Point3::new(0.0, top, 0.0)];
    for &(radius, y) in rings {
        positions.extend((0..around).map(|column| {
            let angle = 2.0 * PI * column as f64 / around as f64;
            Point3::new(radius * angle.sin(), y, radius * angle.cos())
        }));
    }
    let vertex = |ring: usize, column: usize| (2 + ring * around + column % around) as u32;
    let mut triangles = Vec::new();
    for column in 0..around {
        triangles.push([0, vertex(0, column + 1), vertex(0, column)]);
        triangles.push([1, vertex(rings.len() - 1, column), vertex(rings.len() - 1, column + 1)]);
        for ring in 1..rings.len() {
            let (a, b) = (vertex(ring - 1, column), vertex(ring - 1, column + 1));
            let (c, d) = (vertex(ring, column + 1), vertex(ring, column));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    surface(positions, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Statistics;

    fn statistics(surface: &Surface) -> Statistics {
        Statistics::new(&Mesh::from_triangles(surface.positions.clone(), &surface.triangles)).unwrap()
    }

    #[test]
    fn closed_shapes_are_closed_and_face_outwards() {
        let shapes = [
            tetrahedron(),
            icosphere(2),
            bar([3, 2, 4], [1., 2., 3.]),
            cylinder(7, 3, 2.0),
            capsule(12, 4, 3.0),
            two_components(),
        ];
        for shape in shapes {
            let statistics = statistics(&shape);
            assert_eq!((statistics.boundary_edges, statistics.non_manifold_edges), (0, 0));
            assert_eq!((statistics.degenerate_triangles, statistics.coincident_vertices), (0, 0));
            assert!(statistics.volume.unwrap() > 0.0);
        }
    }

    #[test]
    fn shapes_have_their_known_sizes() {
        let close = |a: f64, b: f64, tolerance: f64| assert!((a - b).abs() <= tolerance * b, "{a} {b}");
        // Flat shapes are exact up to rounding; round ones lose the share of their chords.
        close(statistics(&bar([3, 2, 4], [1., 2., 3.])).volume.unwrap(), 6.0, 1e-12);
        close(statistics(&grid(4, 3)).area, 1.0, 1e-12);
        close(statistics(&icosphere(3)).area, 4.0 * PI, 0.01);
        close(statistics(&capsule(48, 8, 3.0)).volume.unwrap(), 3.0 * PI + 4.0 * PI / 3.0, 0.01);
        assert_eq!(icosphere(3).vertex_count(), 642);
        assert_eq!(two_components().components().sizes, [42, 42]);
    }

    #[test]
    fn a_seam_is_welded_away_and_defects_are_where_they_are_said_to_be() {
        let seamed = Statistics::new(&seamed_cylinder(8, 3)).unwrap();
        assert_eq!((seamed.vertices, seamed.welded_vertices, seamed.boundary_edges), (36, 32, 16));
        assert_eq!(Statistics::new(&with_zero_area_triangle()).unwrap().degenerate_triangles, 1);
        assert_eq!(Statistics::new(&with_duplicated_vertex()).unwrap().coincident_vertices, 1);
        assert_eq!(Statistics::new(&with_unreferenced_vertex()).unwrap().unreferenced_vertices, 1);
    }
}
