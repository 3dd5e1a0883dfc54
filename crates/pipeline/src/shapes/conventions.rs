//! The names that programs give to shapes of faces.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A convention of names for shapes of faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Convention {
    /// Apple's ARKit: `eyeBlinkLeft`, `jawOpen`.
    Arkit,
    /// ICT FaceKit: `eyeBlink_L`, `jawOpen`.
    Ict,
    /// VRM 1: `blinkLeft`, `aa`. It has few shapes; those of ARKit that come nearest have its names.
    Vrm,
    /// Oculus' visemes: `viseme_aa`. As for VRM, ARKit's nearest ones have its names.
    Oculus,
}

/// ARKit's shapes that have a side.
const SIDED: [&str; 18] = [
    "browDown",
    "browOuterUp",
    "cheekSquint",
    "eyeBlink",
    "eyeLookDown",
    "eyeLookIn",
    "eyeLookOut",
    "eyeLookUp",
    "eyeSquint",
    "eyeWide",
    "mouthDimple",
    "mouthFrown",
    "mouthLowerDown",
    "mouthPress",
    "mouthSmile",
    "mouthStretch",
    "mouthUpperUp",
    "noseSneer",
];

/// ARKit's shapes that have none, and those whose side is a direction.
const WHOLE: [&str; 16] = [
    "browInnerUp",
    "cheekPuff",
    "jawForward",
    "jawLeft",
    "jawOpen",
    "jawRight",
    "mouthClose",
    "mouthFunnel",
    "mouthLeft",
    "mouthPucker",
    "mouthRight",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
    "tongueOut",
];

/// Names of VRM 1 and Oculus with the ARKit shape that comes nearest, if any does.
const MOUTHS: [[Option<&str>; 3]; 7] = [
    [Some("jawOpen"), Some("aa"), Some("viseme_aa")],
    [Some("mouthPucker"), Some("ou"), Some("viseme_U")],
    [Some("mouthFunnel"), Some("oh"), Some("viseme_O")],
    [None, Some("ih"), Some("viseme_I")],
    [None, Some("ee"), Some("viseme_E")],
    [Some("eyeBlinkLeft"), Some("blinkLeft"), None],
    [Some("eyeBlinkRight"), Some("blinkRight"), None],
];

impl Convention {
    /// What this convention calls the shape that any of them calls `name`; `None` if it has no such shape, or none knows the name.
    pub fn name_of(self, name: &str) -> Option<String> {
        let mouth = |arkit: Option<&str>| {
            MOUTHS.iter().find(|row| row.contains(&Some(name)) || (arkit.is_some() && row[0] == arkit))
        };
        let arkit = arkit_name(name).or_else(|| mouth(None)?[0].map(str::to_owned));
        match self {
            Self::Arkit => arkit,
            Self::Ict => ict_name(&arkit?),
            Self::Vrm => mouth(arkit.as_deref())?[1].map(str::to_owned),
            Self::Oculus => mouth(arkit.as_deref())?[2].map(str::to_owned),
        }
    }
}

/// ARKit's name of a shape that ARKit or ICT calls `name`.
fn arkit_name(name: &str) -> Option<String> {
    if WHOLE.contains(&name) {
        return Some(name.into());
    }
    for (ict, arkit) in [("_L", "Left"), ("_R", "Right")] {
        let stem = name.strip_suffix(ict).or_else(|| name.strip_suffix(arkit));
        if let Some(stem) = stem.filter(|stem| SIDED.contains(stem)) {
            return Some(format!("{stem}{arkit}"));
        }
    }
    None
}

/// ICT's name of a shape of ARKit; `browInnerUp` and `cheekPuff` have two halves there.
fn ict_name(arkit: &str) -> Option<String> {
    let halved = ["browInnerUp", "cheekPuff"];
    if halved.contains(&arkit) || arkit == "tongueOut" {
        return None;
    }
    for (side, ending) in [("Left", "_L"), ("Right", "_R")] {
        if let Some(stem) = arkit.strip_suffix(side).filter(|stem| SIDED.contains(stem)) {
            return Some(format!("{stem}{ending}"));
        }
    }
    Some(arkit.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_one_convention_are_found_in_the_others() {
        use Convention::{Arkit, Ict, Oculus, Vrm};
        for (name, to, expected) in [
            ("eyeBlink_L", Arkit, Some("eyeBlinkLeft")),
            ("eyeBlinkRight", Ict, Some("eyeBlink_R")),
            ("jawLeft", Ict, Some("jawLeft")),
            ("eyeBlink_R", Vrm, Some("blinkRight")),
            ("jawOpen", Vrm, Some("aa")),
            ("aa", Arkit, Some("jawOpen")),
            ("viseme_U", Vrm, Some("ou")),
            ("ee", Oculus, Some("viseme_E")),
            ("mouthSmile_L", Vrm, None),
            ("browInnerUp", Ict, None),
            ("browInnerUp_L", Arkit, None),
            ("ih", Arkit, None),
            ("myShape", Arkit, None),
            ("jawOpen", Arkit, Some("jawOpen")),
        ] {
            assert_eq!(to.name_of(name).as_deref(), expected, "{name}");
        }
    }

    #[test]
    fn there_and_back_is_the_same_name() {
        for stem in SIDED {
            for name in [format!("{stem}Left"), format!("{stem}Right")] {
                let ict = Convention::Ict.name_of(&name).unwrap();
                assert_eq!(Convention::Arkit.name_of(&ict), Some(name));
            }
        }
    }
}
