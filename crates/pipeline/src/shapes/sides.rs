//! Left and right in names of shapes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A side of a face or body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The left one.
    Left,
    /// The right one.
    Right,
}

/// Endings of names, left and right.
const ENDINGS: [[&str; 2]; 7] =
    [["Left", "Right"], ["left", "right"], ["LEFT", "RIGHT"], ["_L", "_R"], ["_l", "_r"], [".L", ".R"], [".l", ".r"]];

/// Beginnings of names, left and right.
const BEGINNINGS: [[&str; 2]; 4] = [["Left", "Right"], ["left", "right"], ["L_", "R_"], ["l_", "r_"]];

/// The side that `name` names, and the name of the same shape of the other side.
pub fn side(name: &str) -> Option<(Side, String)> {
    let sides = [Side::Left, Side::Right];
    for pair in ENDINGS {
        for (i, ending) in pair.into_iter().enumerate() {
            if let Some(stem) = name.strip_suffix(ending).filter(|stem| !stem.is_empty()) {
                return Some((sides[i], format!("{stem}{}", pair[1 - i])));
            }
        }
    }
    for pair in BEGINNINGS {
        for (i, beginning) in pair.into_iter().enumerate() {
            if let Some(rest) = name.strip_prefix(beginning).filter(|rest| !rest.is_empty()) {
                return Some((sides[i], format!("{}{rest}", pair[1 - i])));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_known_in_the_usual_ways_and_the_other_of_the_other_is_the_name() {
        for (name, other) in [
            ("eyeBlinkLeft", "eyeBlinkRight"),
            ("eyeBlink_L", "eyeBlink_R"),
            ("smile.l", "smile.r"),
            ("L_Smile", "R_Smile"),
            ("leftSmile", "rightSmile"),
        ] {
            assert_eq!(side(name), Some((Side::Left, other.into())));
            assert_eq!(side(other), Some((Side::Right, name.into())));
        }
        for name in ["jawOpen", "tongue", "Left", "_L", ""] {
            assert_eq!(side(name), None, "{name}");
        }
    }
}
