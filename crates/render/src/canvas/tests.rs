use super::*;
use crate::colour::{CRIMSON, SAND, STEEL, WHITE};
use crate::view::{Direction, UpAxis};
use proptest::prelude::*;

/// A sphere of unit radius about the origin, by longitude and latitude.
fn sphere(rings: u32, segments: u32) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    for ring in 0..=rings {
        let (sin, cos) = (std::f64::consts::PI * f64::from(ring) / f64::from(rings)).sin_cos();
        for segment in 0..segments {
            let turn = std::f64::consts::TAU * f64::from(segment) / f64::from(segments);
            positions.push(Point3::new(sin * turn.sin(), cos, sin * turn.cos()));
        }
    }
    let at = |ring: u32, segment: u32| ring * segments + segment % segments;
    let quads = (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment)));
    let triangles = quads
        .flat_map(|(r, s)| [[at(r, s), at(r + 1, s), at(r + 1, s + 1)], [at(r, s), at(r + 1, s + 1), at(r, s + 1)]]);
    let triangles = triangles.collect();
    (positions, triangles)
}

fn square(z: f64) -> Vec<Point3<f64>> {
    [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point3::new(x, y, z)).to_vec()
}

const SQUARE: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

fn picture_of(canvas: &Canvas) -> Picture {
    let mut picture = Picture::new(canvas.width, canvas.height, WHITE);
    canvas.draw_onto(&mut picture, 0, 0);
    picture
}

fn seen(view: &View, positions: &[Point3<f64>]) -> Vec<[f32; 3]> {
    Canvas::new(100, 100, *view).as_seen(positions)
}

fn front(positions: &[Point3<f64>]) -> View {
    View::fit(positions.iter().copied(), Direction::Front, UpAxis::Y)
}

#[test]
fn the_silhouette_of_a_sphere_has_the_area_of_its_disc() {
    let (positions, triangles) = sphere(64, 128);
    for direction in [Direction::Front, Direction::Side, Direction::ThreeQuarter] {
        let view = View::fit(positions.iter().copied(), direction, UpAxis::Y);
        let mut canvas = Canvas::new(200, 160, view);
        canvas.mesh(&positions, &triangles, &Paint::Plain(STEEL));
        let area: f64 = (0..160).flat_map(|y| (0..200).map(move |x| (x, y))).map(|(x, y)| canvas.resolve(x, y).1).sum();
        let radius = view.pixels_per_unit(200.0, 160.0);
        // A polygon of 128 corners lacks 0.04 % of its circle; sampling adds about as much noise.
        let expected = std::f64::consts::PI * radius * radius;
        assert!((area / expected - 1.0).abs() < 2e-3, "{direction:?}: {area} of {expected}");
    }
}

#[test]
fn the_nearer_surface_hides_the_farther_in_any_order() {
    let (near, far) = (square(1.0), square(0.0));
    let view = front(&near);
    for near_first in [true, false] {
        let mut canvas = Canvas::new(50, 50, view);
        let mut meshes = [(&near, CRIMSON), (&far, STEEL)];
        if !near_first {
            meshes.reverse();
        }
        for (positions, colour) in meshes {
            canvas.mesh(positions, &SQUARE, &Paint::Plain(colour));
        }
        let [r, g, b] = picture_of(&canvas).at(25, 25).unwrap();
        assert!(r > g && r > b, "red lies before blue");
    }
}

#[test]
fn pictures_do_not_depend_on_the_order_of_triangles() {
    let (positions, mut triangles) = sphere(12, 20);
    // Surfaces in the very same place are the hard case.
    let mut colours: Vec<Colour> = (0..triangles.len()).map(crate::colour::of_part).collect();
    triangles.extend_from_within(..);
    colours.extend(colours.clone().iter().rev());
    let draw = |triangles: &[[u32; 3]], colours: &[Colour]| {
        let mut canvas = Canvas::new(90, 90, front(&positions));
        canvas.mesh(&positions, triangles, &Paint::Triangles(colours));
        picture_of(&canvas)
    };
    let forwards = draw(&triangles, &colours);
    triangles.reverse();
    colours.reverse();
    let backwards = draw(&triangles, &colours);
    // Normals are summed in another order, which may round a channel to the next step of brightness.
    let differing = forwards.pixels.iter().zip(&backwards.pixels).filter(|(a, b)| a != b).count();
    assert!(differing <= 8, "{differing} pixels differ");
}

#[test]
fn the_same_input_gives_the_same_picture_on_every_thread() {
    let (positions, triangles) = sphere(20, 30);
    let draw = || {
        let mut canvas = Canvas::new(120, 100, front(&positions));
        let values: Vec<f64> = positions.iter().map(|p| p.x).collect();
        canvas.mesh(&positions, &triangles, &Paint::Values { values: &values, scale: &Scale::new(-1.0, 1.0) });
        canvas.dots(&[Dot { at: positions[70], label: Some("7".to_string()), colour: CRIMSON }]);
        picture_of(&canvas).small_png()
    };
    let here = draw();
    std::thread::scope(|scope| {
        let others: Vec<_> = (0..4).map(|_| scope.spawn(draw)).collect();
        others.into_iter().for_each(|other| assert_eq!(other.join().unwrap(), here));
    });
}

#[test]
fn a_mirrored_mesh_seen_from_the_mirrored_side_has_the_mirrored_silhouette() {
    let (mut positions, triangles) = sphere(10, 14);
    positions.iter_mut().for_each(|p| *p = Point3::new(p.x * 2.0 + 0.3 * p.y, p.y, p.z * 0.7));
    let mirrored: Vec<Point3<f64>> = positions.iter().map(|p| Point3::new(-p.x, p.y, p.z)).collect();
    let flipped: Vec<[u32; 3]> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let draw = |positions: &[Point3<f64>], triangles: &[[u32; 3]], yaw: f64| {
        let view = View::fit(positions.iter().copied(), Direction::Angles { yaw, pitch: 20.0 }, UpAxis::Y);
        let mut canvas = Canvas::new(101, 80, view);
        canvas.mesh(positions, triangles, &Paint::Plain(SAND));
        canvas
    };
    let (left, right) = (draw(&positions, &triangles, 33.0), draw(&mirrored, &flipped, -33.0));
    let differing = (0..80).flat_map(|y| (0..101).map(move |x| (x, y)));
    let differing = differing.filter(|&(x, y)| left.resolve(x, y).1 != right.resolve(100 - x, y).1).count();
    // A sample on an edge belongs to the triangle at its right, also in the mirror.
    assert!(differing <= 4, "{differing}");
}

#[test]
fn a_point_lands_on_the_pixel_it_is_projected_to() {
    let (positions, triangles) = sphere(24, 36);
    let view = View::fit(positions.iter().copied(), Direction::ThreeQuarter, UpAxis::Y);
    for vertex in [200, 300, 420] {
        let mut canvas = Canvas::new(180, 140, view);
        let at = positions[vertex];
        let placed = canvas.place(&at).unwrap();
        canvas.mesh(&positions, &triangles, &Paint::Plain(STEEL));
        // A small sphere about the point, half of it outside the large one, before or behind it.
        let bump: Vec<Point3<f64>> = positions.iter().map(|p| at + (p - Point3::origin()) * 0.03).collect();
        canvas.mesh(&bump, &triangles, &Paint::Plain(CRIMSON));
        let [r, _, b] = picture_of(&canvas).at(placed.x as i32, placed.y as i32).unwrap();
        let drawn_red = r > b;
        assert_eq!(drawn_red, placed.depth < 3.0, "vertex {vertex}");
    }
}

#[test]
fn dots_before_a_surface_are_seen_and_those_behind_it_hidden() {
    let (positions, triangles) = sphere(24, 36);
    let mut canvas = Canvas::new(150, 150, front(&positions));
    canvas.mesh(&positions, &triangles, &Paint::Plain(STEEL));
    let dot = |at| Dot { at, label: None, colour: CRIMSON };
    canvas.dots(&[
        dot(Point3::new(0.0, 0.0, 1.0)),
        dot(Point3::new(0.3, 0.3, -0.9)),
        dot(Point3::new(0.0, 90.0, 0.0)),
        dot(Point3::new(f64::NAN, 0.0, 0.0)),
    ]);
    let drawn = canvas.draw_onto(&mut Picture::new(150, 150, WHITE), 0, 0);
    assert_eq!(drawn, DotsDrawn { visible: 1, hidden: 1, outside: 2, without_label: 0 });
}

#[test]
fn a_flipped_triangle_stands_out() {
    let view = front(&square(0.0));
    let mut canvas = Canvas::new(40, 40, view);
    canvas.mesh(&square(0.0), &[[0, 1, 2], [0, 3, 2]], &Paint::Plain(STEEL));
    let picture = picture_of(&canvas);
    let ([_, _, right], [red, _, blue]) = (picture.at(28, 28).unwrap(), picture.at(10, 12).unwrap());
    assert!(right > 120 && red > blue);
}

#[test]
fn the_edges_of_a_cube_are_sharp_and_a_sphere_is_smooth() {
    let corners = crate::Bounds { low: Point3::origin(), high: Point3::new(1.0, 1.0, 1.0) }.corners();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let cube: Vec<[u32; 3]> = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let view = View::fit(corners.iter().copied(), Direction::ThreeQuarter, UpAxis::Y);
    let points = seen(&view, &corners);
    let normals = Normals::new(&points, &cube);
    for triangle in &cube {
        let [a, b, c] = normals.at_corners(triangle.map(|v| v as usize));
        assert_eq!((a, b), (b, c), "a face of a cube has one normal");
    }
    let (positions, triangles) = sphere(12, 18);
    let points = seen(&view, &positions);
    let normals = Normals::new(&points, &triangles);
    let [a, b, _] = normals.at_corners(triangles[150].map(|v| v as usize));
    assert_ne!(a, b);
}

#[test]
fn a_hundred_pictures_of_two_shaded_meshes_fit_into_a_page() {
    let (mut positions, triangles) = sphere(160, 320);
    // Bumps make more shades and outlines than an animal has, on more than twice its area (which takes 10 to 20 kB).
    for p in &mut positions {
        *p *= 1.0 + 0.12 * (7.0 * p.x).sin() * (6.0 * p.y).cos() + 0.05 * (23.0 * p.z + 9.0 * p.x).sin();
    }
    let mut picture = Picture::new(480, 240, WHITE);
    for (x, colour) in [(0, STEEL), (240, SAND)] {
        let view = View::fit(positions.iter().copied(), Direction::ThreeQuarter, UpAxis::Y);
        let mut canvas = Canvas::new(240, 240, view);
        canvas.mesh(&positions, &triangles, &Paint::Plain(colour));
        canvas.draw_onto(&mut picture, x, 0);
    }
    let size = picture.small_png().len();
    // As base64 a hundred of them then stay below five megabytes.
    assert!(size < 35_000, "{size} bytes");
}

#[test]
fn a_drawing_far_off_the_picture_does_no_harm() {
    let mut canvas = Canvas::new(20, 20, front(&square(0.0)));
    canvas.mesh(&square(0.0), &SQUARE, &Paint::Plain(STEEL));
    canvas.dots(&[Dot { at: Point3::new(0.5, 0.5, 0.0), label: Some("1".to_string()), colour: CRIMSON }]);
    let mut picture = Picture::new(20, 20, WHITE);
    for (x, y) in [(i32::MAX, i32::MAX), (i32::MIN, i32::MIN), (0, i32::MAX - 3)] {
        assert_eq!(canvas.draw_onto(&mut picture, x, y).visible, 1);
    }
    assert_eq!(picture, Picture::new(20, 20, WHITE));
}

#[test]
fn what_cannot_be_drawn_is_counted() {
    let mut positions = square(0.0);
    positions.extend([Point3::new(f64::NAN, 0.0, 0.0), Point3::new(1e300, 0.0, 0.0)]);
    let mut canvas = Canvas::new(20, 20, front(&square(0.0)));
    let triangles = [[0, 1, 2], [0, 1, 99], [0, 1, 4], [0, 1, 5], [0, 0, 0]];
    let drawn = canvas.mesh(&positions, &triangles, &Paint::Plain(STEEL));
    assert_eq!(drawn, Drawn { triangles: 2, without_vertex: 1, not_finite: 2 });
    assert_eq!(canvas.mesh(&[], &[], &Paint::Plain(STEEL)), Drawn::default());
}

/// Numbers of every kind, ordinary ones among them.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -2.0..2.0f64, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(1e9)]
}

proptest! {
    #[test]
    fn no_input_makes_drawing_fail(
        numbers in prop::collection::vec([number(), number(), number()], 0..12),
        triangles in prop::collection::vec(any::<[u8; 3]>(), 0..20),
        values in prop::collection::vec(any::<f64>(), 0..12),
        framed in 0usize..12, width in 0u32..40, height in 0u32..40, yaw in number(), pitch in number(), up in 0..3,
    ) {
        let positions: Vec<Point3<f64>> = numbers.into_iter().map(Point3::from).collect();
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| u32::from(v % 13))).collect();
        let up = [UpAxis::X, UpAxis::Y, UpAxis::Z][up as usize];
        let view = View::fit(positions.iter().copied().take(framed), Direction::Angles { yaw, pitch }, up);
        let mut canvas = Canvas::new(width, height, view);
        let scale = Scale::covering(values.iter().copied());
        for paint in [Paint::Plain(STEEL), Paint::Values { values: &values, scale: &scale }, Paint::Triangles(&[SAND])] {
            let drawn = canvas.mesh(&positions, &triangles, &paint);
            prop_assert_eq!(drawn.triangles + drawn.without_vertex + drawn.not_finite, triangles.len());
        }
        let dots = positions.iter().map(|at| Dot { at: *at, label: Some("1".to_string()), colour: CRIMSON });
        let dots: Vec<Dot> = dots.collect();
        canvas.dots(&dots);
        let mut picture = Picture::new(30, 30, WHITE);
        let drawn = canvas.draw_onto(&mut picture, 7, -3);
        prop_assert_eq!(drawn.visible + drawn.hidden + drawn.outside, dots.len());
    }
}
