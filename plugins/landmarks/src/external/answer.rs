//! The pairs in the output of a program.

use std::collections::HashSet;

use mimesh_core::{
    mesh::{Surface, SurfacePoint},
    spatial::ClosestPoint,
    stage::{Marker, ProposedPair, TransferPair},
};
use nalgebra::Point3;
use serde::Deserialize;

/// The answer: a mapping, or the sequence of pairs alone.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum Answer {
    /// As a mapping.
    Mapping {
        /// The pairs.
        pairs: Vec<Pair>,
    },
    /// Without one.
    Pairs(Vec<Pair>),
}

/// A pair of points.
#[derive(Debug, Deserialize)]
pub struct Pair {
    name: Option<String>,
    source: Point,
    target: Point,
    #[serde(default = "half")]
    confidence: f64,
}

/// A program that gives no confidences knows them not.
fn half() -> f64 {
    0.5
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Point {
    Vertex(u32),
    Triangle { triangle: u32, barycentric: [f64; 3] },
    Position { position: [f64; 3] },
}

impl Answer {
    /// Reads the output of a program.
    ///
    /// # Errors
    ///
    /// What is wrong with it.
    pub fn parse(output: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(output).map_err(|error| {
            let begin: String = String::from_utf8_lossy(&output[..output.len().min(60)]).escape_debug().collect();
            format!("it prints no pairs as JSON ({error}), but `{begin}`")
        })
    }

    /// The pairs on the surfaces of `pair`, and the number of those left out whose points another pair or a click has.
    ///
    /// # Errors
    ///
    /// Names the pair whose points do not exist or whose confidence is none.
    pub fn pairs(self, pair: TransferPair<'_>) -> Result<(Vec<ProposedPair>, usize), String> {
        let (Self::Mapping { pairs } | Self::Pairs(pairs)) = self;
        let sides = [Side::new(pair.source)?, Side::new(pair.target)?];
        let mut taken: [HashSet<[u64; 3]>; 2] = Default::default();
        for marker in pair.markers {
            taken[0].insert(sides[0].place(marker.source));
            taken[1].insert(sides[1].place(marker.target));
        }
        let mut names: HashSet<String> = pair.markers.iter().map(|marker| marker.name.clone()).collect();
        let (mut found, mut left_out) = (Vec::new(), 0);
        for (index, Pair { name, source, target, confidence }) in pairs.into_iter().enumerate() {
            let wrong = |message: String| format!("pair {index} (from 0): {message}");
            if !(0.0..=1.0).contains(&confidence) {
                return Err(wrong(format!("expected a confidence from 0 to 1, found {confidence}")));
            }
            let source = sides[0].point(source).map_err(|message| wrong(format!("source: {message}")))?;
            let target = sides[1].point(target).map_err(|message| wrong(format!("target: {message}")))?;
            let places = [sides[0].place(source), sides[1].place(target)];
            if taken.iter().zip(&places).any(|(taken, place)| taken.contains(place)) {
                left_out += 1;
                continue;
            }
            taken.iter_mut().zip(places).for_each(|(taken, place)| _ = taken.insert(place));
            let wanted = name.unwrap_or_else(|| format!("external{}", index + 1));
            let numbered = (2..).map(|number| format!("{wanted}-{number}"));
            let mut free = std::iter::once(wanted.clone()).chain(numbered).filter(|name| !names.contains(name));
            let name = free.next().expect("there are infinitely many");
            names.insert(name.clone());
            found.push(ProposedPair { marker: Marker { name, source, target }, confidence });
        }
        Ok((found, left_out))
    }
}

/// A surface on which points are found.
struct Side<'a> {
    surface: &'a Surface,
    closest: ClosestPoint,
    /// Whether a triangle has the vertex.
    used: Vec<bool>,
}

impl<'a> Side<'a> {
    fn new(surface: &'a Surface) -> Result<Self, String> {
        let closest = ClosestPoint::new(&surface.positions, &surface.triangles).map_err(|error| error.to_string())?;
        let mut used = vec![false; surface.vertex_count()];
        surface.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
        Ok(Self { surface, closest, used })
    }

    fn point(&self, point: Point) -> Result<SurfacePoint, String> {
        match point {
            Point::Vertex(vertex) if self.used.get(vertex as usize) == Some(&true) => Ok(SurfacePoint::Vertex(vertex)),
            Point::Vertex(vertex) => Err(format!("no triangle has a vertex {vertex}")),
            Point::Triangle { triangle, barycentric } => {
                let sum: f64 = barycentric.iter().sum();
                // Printed numbers have few digits.
                let is_inside =
                    barycentric.iter().all(|x| (-1e-6..=1.0 + 1e-6).contains(x)) && (sum - 1.0).abs() < 1e-3;
                if triangle as usize >= self.surface.triangle_count() {
                    return Err(format!(
                        "there is no triangle {triangle}: expected 0 to {}",
                        self.surface.triangle_count() - 1
                    ));
                }
                if !is_inside {
                    return Err(format!(
                        "expected barycentric coordinates from 0 to 1 with the sum 1, found {barycentric:?}"
                    ));
                }
                Ok(SurfacePoint::Triangle(triangle, barycentric.map(|x| x.max(0.0) / sum)))
            }
            Point::Position { position } => {
                let position = Point3::from(position);
                let found = self.closest.find(&position, f64::INFINITY, |_| true);
                let found = found.ok_or_else(|| format!("no point is near to {position}"))?;
                Ok(SurfacePoint::Triangle(found.triangle, found.barycentric))
            }
        }
    }

    fn place(&self, point: SurfacePoint) -> [u64; 3] {
        point.position(self.surface, &self.surface.positions).coords.map(f64::to_bits).into()
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    fn answered(text: &str) -> Result<(Vec<ProposedPair>, usize), String> {
        let mesh = meshes::icosphere(1);
        let clicks = [Marker { name: "a".into(), source: SurfacePoint::Vertex(3), target: SurfacePoint::Vertex(3) }];
        let pair = TransferPair { source: &mesh, target: &mesh, markers: &clicks, proximity: None };
        let (pairs, left_out) = Answer::parse(text.as_bytes())?.pairs(pair)?;
        let proposal = mimesh_core::stage::Proposal { pairs: pairs.clone(), ..Default::default() };
        proposal.check(TransferPair { markers: &[], ..pair }).unwrap();
        Ok((pairs, left_out))
    }

    #[test]
    fn every_notation_of_a_point_is_read() {
        let text = r#"{ "pairs": [
            { "name": "a", "source": 0, "target": { "triangle": 7, "barycentric": [0.333, 0.333, 0.334] }, "confidence": 1 },
            { "source": { "position": [0, 0, 9] }, "target": 5 } ] }"#;
        let (pairs, left_out) = answered(text).unwrap();
        assert_eq!((pairs.len(), left_out), (2, 0));
        assert_eq!((pairs[0].marker.name.as_str(), pairs[1].marker.name.as_str()), ("a-2", "external2"));
        assert_eq!((pairs[0].confidence, pairs[1].confidence), (1.0, 0.5));
    }

    #[test]
    fn points_that_are_taken_are_left_out() {
        let text = r#"[{ "source": 0, "target": 3 }, { "source": 1, "target": 1 }, { "source": 1, "target": 2 }]"#;
        let (pairs, left_out) = answered(text).unwrap();
        assert_eq!((pairs.len(), left_out), (1, 2));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, expected) in [
            ("Loading model", "it prints no pairs as JSON"),
            (r#"[{ "source": 900, "target": 1 }]"#, "pair 0 (from 0): source: no triangle has a vertex 900"),
            (
                r#"[{ "source": 1, "target": { "triangle": 80, "barycentric": [1, 0, 0] } }]"#,
                "target: there is no triangle 80",
            ),
            (r#"[{ "source": 1, "target": { "triangle": 8, "barycentric": [1, 1, 0] } }]"#, "with the sum 1"),
            (r#"[{ "source": 1, "target": 1, "confidence": 2 }]"#, "expected a confidence from 0 to 1, found 2"),
        ] {
            let error = answered(text).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
