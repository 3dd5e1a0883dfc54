//! Completing markers across the plane of symmetry of both meshes.
//!
//! A pair has a mirror partner if another pair has its name with left and right exchanged, or lies on both meshes where its
//! mirror image is attached. Pairs without one get one: the closest places to the mirrored positions. Mirroring again
//! then adds nothing.

use nalgebra::Point3;

use super::{
    Entry, MarkerFile, Side,
    attach::{Attached, Attacher, FARTHEST},
};
use crate::{core::mesh::bounding_box, diagnostic::Result};

/// Points nearer to the plane than this, relative to the diagonal, lie on it; and partners are so near to mirror images.
const NEAR: f64 = 0.01;

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Where it crosses the axis, in the unit of the mesh.
    pub offset: f64,
}

impl Plane {
    /// That through the middle of the bounding box of `side`.
    pub fn middle(side: Side<'_>, axis: usize) -> Self {
        let (low, high) = bounding_box(&side.surface.positions);
        Self { axis, offset: 0.5 * (low[axis] + high[axis]) }
    }

    /// The mirror image of `p`.
    pub fn mirror(self, p: &Point3<f64>) -> Point3<f64> {
        let mut image = *p;
        image[self.axis] = 2.0 * self.offset - p[self.axis];
        image
    }
}

/// What became of a pair.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It lies on the plane.
    OnPlane,
    /// It has a partner: that one's number from 0.
    Partner(usize),
    /// A partner was added, this far from the mirrored positions on source and target, relative to the diagonals.
    Added(usize, [f64; 2]),
    /// None was added, for this reason.
    Left(String),
}

/// What mirroring did, a line a pair that was there before.
#[derive(Clone, Debug, Default)]
pub struct Mirrored {
    /// The markers with those that were added at the end.
    pub markers: MarkerFile,
    /// What became of each pair that was there before.
    pub outcomes: Vec<Outcome>,
}

/// Adds to `markers`, all of which are on the meshes, the mirror partners that are missing.
///
/// # Errors
///
/// As [`Attacher::new`].
pub fn mirror(markers: &MarkerFile, sides: [Side<'_>; 2], planes: [Plane; 2]) -> Result<Mirrored> {
    let attachers = [Attacher::new(sides[0])?, Attacher::new(sides[1])?];
    let count = markers.entries.len();
    let point = |entry: &Entry, k: usize| entry.of(sides[k].name);
    let positions: Vec<Option<[Point3<f64>; 2]>> = markers
        .entries
        .iter()
        .map(|entry| {
            let [s, t] = [point(entry, 0)?, point(entry, 1)?];
            Some([attachers[0].position(s), attachers[1].position(t)])
        })
        .collect();
    let image = |k: usize, p: &Point3<f64>| attachers[k].attach(&planes[k].mirror(p));
    let images: Vec<Option<[Attached; 2]>> =
        positions.iter().map(|at| at.map(|at| [image(0, &at[0]), image(1, &at[1])])).collect();
    // Whether the image of pair i lies on pair j, on each side.
    let falls_on = |i: usize, j: usize| -> [bool; 2] {
        let (Some(images), Some(at)) = (&images[i], &positions[j]) else { return [false; 2] };
        [0, 1].map(|k| (attachers[k].position(images[k].point) - at[k]).norm() <= NEAR * attachers[k].diagonal)
    };
    let mut result = Mirrored { markers: markers.clone(), outcomes: vec![] };
    for i in 0..count {
        let outcome = match (&positions[i], &images[i]) {
            (Some(at), Some(images)) => {
                let on_plane = [0, 1].map(|k| {
                    let plane = planes[k];
                    (at[k][plane.axis] - plane.offset).abs() <= NEAR * attachers[k].diagonal
                });
                let named = markers.entries[i].name.as_deref().and_then(|name| {
                    let other = exchange_sides(name)?;
                    markers.entries.iter().position(|entry| entry.name.as_deref() == Some(&other))
                });
                let others = || (0..count).filter(|&j| j != i);
                let placed = others()
                    .find(|&j| falls_on(i, j) == [true; 2])
                    .or_else(|| others().find(|&j| falls_on(j, i) == [true; 2]));
                let beside = || others().find(|&j| falls_on(i, j) != [false; 2]);
                let farthest = images[0].distance.max(images[1].distance);
                if on_plane == [true; 2] {
                    Outcome::OnPlane
                } else if let Some(j) = named.or(placed) {
                    Outcome::Partner(j)
                } else if on_plane != [false; 2] {
                    let (on, off) = if on_plane[0] { ("source", "target") } else { ("target", "source") };
                    Outcome::Left(format!("on the plane of the {on}, but not on that of the {off}"))
                } else if let Some(j) = beside() {
                    let on = if falls_on(i, j)[0] { "source" } else { "target" };
                    Outcome::Left(format!("its mirror image is marker {} on the {on} only", markers.name(j)))
                } else if farthest > FARTHEST {
                    let side = if images[0].distance > images[1].distance { "source" } else { "target" };
                    Outcome::Left(format!(
                        "its mirror image lies {:.1} % of the diagonal off the {side}",
                        100.0 * farthest
                    ))
                } else {
                    let name = markers.entries[i].name.as_deref().map(|name| free_name(&result.markers, name));
                    let points = [images[0].point, images[1].point];
                    let at = [0, 1].map(|k| Some(attachers[k].position(points[k])));
                    result.markers.entries.push(Entry { name, at, ..Entry::new(points[0], points[1]) });
                    let number = result.markers.entries.len() - 1;
                    Outcome::Added(number, [images[0].distance, images[1].distance])
                }
            }
            _ => Outcome::Left("it has no target yet".into()),
        };
        result.outcomes.push(outcome);
    }
    Ok(result)
}

/// A name for the mirror partner of `name` that no marker has.
fn free_name(markers: &MarkerFile, name: &str) -> String {
    let wanted = exchange_sides(name).unwrap_or_else(|| format!("{name} mirrored"));
    let taken = |name: &str| markers.entries.iter().any(|entry| entry.name.as_deref() == Some(name));
    let mut free = wanted.clone();
    let mut number = 2;
    while taken(&free) {
        free = format!("{wanted} {number}");
        number += 1;
    }
    free
}

/// `name` with left and right exchanged, as words (`left ear`, `earLeft`) or as a letter at its end or beginning (`ear_L`,
/// `ear.l`, `L_ear`); `None` if it tells no side. Twice gives `name` again.
pub fn exchange_sides(name: &str) -> Option<String> {
    const WORDS: [[&str; 2]; 3] = [["left", "right"], ["Left", "Right"], ["LEFT", "RIGHT"]];
    let mut result = String::new();
    let mut changed = false;
    let mut at = 0;
    while let Some(c) = name[at..].chars().next() {
        let before = name[..at].chars().next_back();
        let found = WORDS.iter().flat_map(|[a, b]| [(a, b), (b, a)]).find(|(word, _)| {
            let Some(rest) = name[at..].strip_prefix(**word) else { return false };
            let after = rest.chars().next();
            // In `cleft` and `upright` no side is told; `earLeft` and `left_ear` tell one.
            let begins = match before {
                Some(before) if before.is_alphabetic() => c.is_uppercase() && before.is_lowercase(),
                _ => true,
            };
            let upper = word.chars().all(char::is_uppercase);
            let ends = after.is_none_or(|after| !after.is_alphabetic() || (!upper && after.is_uppercase()));
            begins && ends
        });
        match found {
            Some((word, other)) => {
                result.push_str(other);
                at += word.len();
                changed = true;
            }
            None => {
                result.push(c);
                at += c.len_utf8();
            }
        }
    }
    if changed {
        return Some(result);
    }
    let other = |c: char| match c {
        'L' => Some('R'),
        'R' => Some('L'),
        'l' => Some('r'),
        'r' => Some('l'),
        _ => None,
    };
    let separates = |c: char| "_.- ".contains(c);
    let chars: Vec<char> = name.chars().collect();
    let mut exchanged = chars.clone();
    match chars[..] {
        [.., separator, last] if separates(separator) && other(last).is_some() => {
            *exchanged.last_mut()? = other(last)?;
        }
        [first, separator, ..] if separates(separator) && other(first).is_some() => exchanged[0] = other(first)?,
        _ => return None,
    }
    Some(exchanged.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn names_tell_sides_as_words_and_as_letters() {
        let other = |name: &str| exchange_sides(name);
        for (name, expected) in [
            ("left ear", "right ear"),
            ("earLeft", "earRight"),
            ("LeftEar", "RightEar"),
            ("EAR_RIGHT", "EAR_LEFT"),
            ("ear_L", "ear_R"),
            ("ear.l", "ear.r"),
            ("R_ear", "L_ear"),
            ("eye L", "eye R"),
        ] {
            assert_eq!(other(name).as_deref(), Some(expected));
        }
        for name in ["cleft", "upright", "nose", "leftover", "tail", "L", ""] {
            assert_eq!(other(name), None, "{name}");
        }
    }

    proptest! {
        #[test]
        fn exchanging_sides_twice_gives_the_name_again(name in "(left|right|Left|RIGHT|[ a-cL-R_.é]){0,6}") {
            if let Some(other) = exchange_sides(&name) {
                prop_assert_eq!(exchange_sides(&other), Some(name));
            }
        }
    }
}
