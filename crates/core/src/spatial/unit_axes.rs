//! Units of length and upward axes, and the change from one to another.

use std::fmt;

use nalgebra::{Matrix3, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A unit of length.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, JsonSchema, PartialEq, Serialize)]
pub enum LengthUnit {
    /// Metre.
    #[default]
    #[serde(rename = "m")]
    Metre,
    /// Centimetre.
    #[serde(rename = "cm")]
    Centimetre,
    /// Millimetre.
    #[serde(rename = "mm")]
    Millimetre,
    /// Inch, 0.0254 m.
    #[serde(rename = "in")]
    Inch,
    /// Foot, 0.3048 m.
    #[serde(rename = "ft")]
    Foot,
}

impl LengthUnit {
    /// All units.
    pub const ALL: [Self; 5] = [Self::Metre, Self::Centimetre, Self::Millimetre, Self::Inch, Self::Foot];

    /// The length in metres.
    pub fn metres(self) -> f64 {
        self.tenths_of_millimetres() / 10_000.0
    }

    /// The factor on numbers in this unit that gives numbers in `other`.
    pub fn factor_to(self, other: Self) -> f64 {
        self.tenths_of_millimetres() / other.tenths_of_millimetres()
    }

    /// The name, as in YAML.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }

    /// The length as an integer, so that a ratio of two is rounded once.
    fn tenths_of_millimetres(self) -> f64 {
        match self {
            Self::Metre => 10_000.0,
            Self::Centimetre => 100.0,
            Self::Millimetre => 10.0,
            Self::Inch => 254.0,
            Self::Foot => 3048.0,
        }
    }
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, JsonSchema, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum UpAxis {
    /// As in glTF, Maya and most files of faces and bodies.
    #[default]
    Y,
    /// As in Blender, Unreal and CAD; from Y up it is a quarter turn about X.
    Z,
    /// Seldom; from Y up each axis takes the place of the next one.
    X,
}

impl UpAxis {
    /// All axes.
    pub const ALL: [Self; 3] = [Self::Y, Self::Z, Self::X];

    /// The name, as in YAML.
    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
            Self::X => "x",
        }
    }

    /// The coordinates with Y up, each as the number of one with this axis up and its sign.
    fn to_y(self) -> Rows {
        match self {
            Self::Y => [(0, 1.0), (1, 1.0), (2, 1.0)],
            Self::Z => [(0, 1.0), (2, 1.0), (1, -1.0)],
            Self::X => [(2, 1.0), (0, 1.0), (1, 1.0)],
        }
    }
}

/// The unit and the upward axis of a mesh, as far as they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshUnits {
    /// The unit of its numbers.
    pub unit: Option<LengthUnit>,
    /// Its upward axis.
    pub up: Option<UpAxis>,
}

impl MeshUnits {
    /// Metres with Y up, as glTF has them.
    pub const METRES_Y_UP: Self = Self { unit: Some(LengthUnit::Metre), up: Some(UpAxis::Y) };

    /// These, and those of `others` where they are not known.
    pub fn or(self, others: Self) -> Self {
        Self { unit: self.unit.or(others.unit), up: self.up.or(others.up) }
    }
}

/// A change of unit and axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitAxes {
    /// The factor.
    pub factor: f64,
    /// The change of axes.
    pub axes: Axes,
    /// Whether positions are taken from LPS to RAS or back before that.
    pub half_turn: bool,
}

/// A change of axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// None.
    Same,
    /// A turn that brings one upward axis to another, e.g. from Z up to Y up: (x, z, −y).
    Up {
        /// The axis that points up before.
        from: UpAxis,
        /// The axis that points up after.
        to: UpAxis,
    },
    /// Y and Z exchanged: (x, z, y), which changes the hand.
    Exchanged,
}

/// For each new coordinate the number of the old one, and its sign.
type Rows = [(usize, f64); 3];

impl Axes {
    fn rows(self) -> Rows {
        match self {
            Self::Same => UpAxis::Y.to_y(),
            Self::Exchanged => [(0, 1.0), (2, 1.0), (1, 1.0)],
            Self::Up { from, to } => {
                let mut rows = [(0, 0.0); 3];
                for ((old, sign), (new, other)) in from.to_y().into_iter().zip(to.to_y()) {
                    rows[new] = (old, sign * other);
                }
                rows
            }
        }
    }
}

impl UnitAxes {
    /// No change.
    pub const IDENTITY: Self = Self { factor: 1.0, axes: Axes::Same, half_turn: false };

    /// From LPS to RAS or back, and nothing else.
    pub const HALF_TURN: Self = Self { half_turn: true, ..Self::IDENTITY };

    /// The change from the unit and axes `from` to `to`; what is not known of either stays.
    pub fn between(from: MeshUnits, to: MeshUnits) -> Self {
        let factor = from.unit.zip(to.unit).map_or(1.0, |(from, to)| from.factor_to(to));
        let axes = match from.up.zip(to.up) {
            Some((from, to)) if from != to => Axes::Up { from, to },
            _ => Axes::Same,
        };
        Self { factor, axes, half_turn: false }
    }

    /// `p` in the other unit and axes.
    pub fn apply(self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.turn(&p.coords)) * self.factor
    }

    /// The direction `v` in the other axes.
    pub fn turn(self, v: &Vector3<f64>) -> Vector3<f64> {
        let v = if self.half_turn { Vector3::new(-v.x, -v.y, v.z) } else { *v };
        Vector3::from(self.axes.rows().map(|(old, sign)| sign * v[old]))
    }

    /// The change of axes as a matrix: a rotation, unless the hand changes.
    pub fn matrix(self) -> Matrix3<f64> {
        Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| self.turn(&axis)))
    }
}

impl fmt::Display for UnitAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axes = match self.axes {
            Axes::Same => String::new(),
            Axes::Up { from, to } => {
                let [from, to] = [from, to].map(|up| up.name().to_uppercase());
                let term = |(old, sign): (usize, f64)| {
                    format!("{}{}", if sign < 0.0 { "-" } else { "" }, ["x", "y", "z"][old])
                };
                format!("turned from {from} up to {to} up, (x, y, z) to ({})", self.axes.rows().map(term).join(", "))
            }
            Axes::Exchanged => "with Y and Z exchanged".into(),
        };
        let half_turn = if self.half_turn { "turned between LPS and RAS, (x, y, z) to (-x, -y, z)" } else { "" };
        let factor = if self.factor == 1.0 { String::new() } else { format!("times {}", self.factor) };
        let parts: Vec<&str> = [&*factor, half_turn, &*axes].into_iter().filter(|part| !part.is_empty()).collect();
        if parts.is_empty() { f.write_str("as they are") } else { f.write_str(&parts.join(" and ")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn up(axis: UpAxis) -> MeshUnits {
        MeshUnits { up: Some(axis), unit: None }
    }

    fn axis(up: UpAxis) -> Vector3<f64> {
        match up {
            UpAxis::Y => Vector3::y(),
            UpAxis::Z => Vector3::z(),
            UpAxis::X => Vector3::x(),
        }
    }

    #[test]
    fn changes_of_axes_are_rotations_that_bring_up_to_up_and_undo_each_other() {
        for from in UpAxis::ALL {
            for to in UpAxis::ALL {
                let there = UnitAxes::between(up(from), up(to));
                let back = UnitAxes::between(up(to), up(from));
                assert_eq!(there.turn(&axis(from)), axis(to), "{from:?} {to:?}");
                assert_eq!(back.matrix() * there.matrix(), Matrix3::identity());
                assert_eq!(there.matrix().determinant(), 1.0);
            }
        }
        let p = Point3::new(1.0, 2.0, 3.0);
        assert_eq!(UnitAxes::between(up(UpAxis::Z), up(UpAxis::Y)).apply(&p), Point3::new(1.0, 3.0, -2.0));
        assert_eq!(UnitAxes::between(up(UpAxis::Y), up(UpAxis::Z)).apply(&p), Point3::new(1.0, -3.0, 2.0));
    }

    #[test]
    fn factors_are_the_nearest_numbers_to_the_ratios_of_lengths() {
        use LengthUnit::{Centimetre, Foot, Inch, Metre, Millimetre};
        for (from, to, factor) in
            [(Metre, Centimetre, 100.0), (Millimetre, Metre, 0.001), (Inch, Millimetre, 25.4), (Foot, Inch, 12.0)]
        {
            assert_eq!(from.factor_to(to), factor);
        }
        assert_eq!(LengthUnit::ALL.map(LengthUnit::metres), [1.0, 0.01, 0.001, 0.0254, 0.3048]);
    }

    #[test]
    fn a_change_is_told_in_words_and_what_is_not_known_stays() {
        let from = MeshUnits { unit: Some(LengthUnit::Centimetre), up: Some(UpAxis::Z) };
        let told = UnitAxes::between(from, MeshUnits::METRES_Y_UP).to_string();
        assert_eq!(told, "times 0.01 and turned from Z up to Y up, (x, y, z) to (x, z, -y)");
        assert_eq!(UnitAxes::between(from, MeshUnits::default()), UnitAxes::IDENTITY);
        assert_eq!(UnitAxes::IDENTITY.to_string(), "as they are");
    }
}
