//! Meshes and poses as a page holds them for its 3D view: rounded to 16 bits, and written as base64.

use std::borrow::Cow;

use base64::{Engine, prelude::BASE64_STANDARD};
use serde_json::{Value, json};

/// The number that stands for an unknown value of a field.
const UNKNOWN: u16 = u16::MAX;

/// The 3D view of a page.
#[derive(Clone, Debug)]
pub enum View3d {
    /// Meshes that can be turned.
    Scene(Box<Scene>),
    /// None, with a sentence that says why.
    None(String),
}

/// The worst poses of a run, worst first.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The script that shows them.
    pub script: Cow<'static, str>,
    /// Where the meshes are looked at from at first: degrees to the right of the front and above the ground.
    pub angles: [f64; 2],
    /// Source and target.
    pub meshes: [SceneMesh; 2],
    /// The poses.
    pub poses: Vec<ScenePose>,
}

/// A mesh at rest.
#[derive(Clone, Debug, Default)]
pub struct SceneMesh {
    /// Its positions (#V).
    pub rest: Coordinates,
    /// Its triangles (#F).
    pub triangles: Vec<[u32; 3]>,
    /// Whether each triangle is of one polygon with the one before (#F).
    pub continues: Vec<bool>,
}

/// A pose of source and target.
#[derive(Clone, Debug, Default)]
pub struct ScenePose {
    /// The name of the pose.
    pub name: String,
    /// The posed source, if it is known.
    pub source: Option<Coordinates>,
    /// The posed target.
    pub result: Coordinates,
    /// What the target is coloured by, if anything.
    pub field: Option<SceneField>,
}

/// Positions in steps of a 65535th of their box.
#[derive(Clone, Debug, Default)]
pub struct Coordinates {
    /// The low corner of the box.
    low: [f64; 3],
    /// The size of the box.
    size: [f64; 3],
    /// Steps from the low corner, three for each position.
    steps: Vec<u16>,
}

/// A number for each vertex of the target, in steps of a 65534th of their scale.
#[derive(Clone, Debug, Default)]
pub struct SceneField {
    /// Name and unit of the numbers, e.g. `error, %`.
    unit: String,
    /// The number at the end of the scale.
    high: f64,
    /// Whether there are larger ones, which count as `high`.
    is_over: bool,
    steps: Vec<u16>,
}

impl Coordinates {
    /// Rounds positions; those that are not finite lie at the low corner.
    pub fn new(positions: &[[f64; 3]]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for position in positions.iter().filter(|position| position.iter().all(|c| c.is_finite())) {
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis]);
                high[axis] = high[axis].max(position[axis]);
            }
        }
        if low[0] > high[0] {
            (low, high) = ([0.0; 3], [0.0; 3]);
        }
        let size = [0, 1, 2].map(|axis: usize| high[axis] - low[axis]);
        let step = |axis: usize, c: f64| {
            let share = if size[axis] > 0.0 { (c - low[axis]) / size[axis] } else { 0.0 };
            // Such a cast puts what is not a number at zero.
            (share * f64::from(u16::MAX)).round() as u16
        };
        let steps = positions.iter().flat_map(|p| [0, 1, 2].map(|axis: usize| step(axis, p[axis]))).collect();
        Self { low, size, steps }
    }

    /// The farthest that rounding moves a position.
    pub fn error(&self) -> f64 {
        let half = self.size.map(|size| 0.5 * size / f64::from(u16::MAX));
        half.iter().map(|half| half * half).sum::<f64>().sqrt()
    }

    fn json(&self) -> Value {
        json!({ "low": self.low, "size": self.size, "steps": base64(&self.steps) })
    }
}

impl SceneField {
    /// Rounds values on a scale from 0 to `high`; `unit` is their name and unit.
    pub fn new(values: &[f64], high: f64, unit: &str) -> Self {
        let step = |value: &f64| match value {
            value if !value.is_finite() || high <= 0.0 => UNKNOWN,
            value => (value / high * f64::from(UNKNOWN - 1)).round().clamp(0.0, f64::from(UNKNOWN - 1)) as u16,
        };
        let is_over = values.iter().any(|value| *value > high);
        Self { unit: unit.into(), high, is_over, steps: values.iter().map(step).collect() }
    }

    fn json(&self) -> Value {
        json!({ "unit": self.unit, "high": self.high, "over": self.is_over, "steps": base64(&self.steps) })
    }
}

impl SceneMesh {
    fn json(&self) -> Value {
        let corners = self.triangles.as_flattened();
        let is_wide = corners.iter().any(|corner| *corner > u32::from(u16::MAX));
        let triangles = if is_wide {
            BASE64_STANDARD.encode(corners.iter().flat_map(|corner| corner.to_le_bytes()).collect::<Vec<_>>())
        } else {
            base64(&corners.iter().map(|corner| *corner as u16).collect::<Vec<_>>())
        };
        let has_polygons = self.continues.contains(&true);
        let continues = has_polygons
            .then(|| BASE64_STANDARD.encode(self.continues.iter().map(|c| u8::from(*c)).collect::<Vec<_>>()));
        json!({ "rest": self.rest.json(), "wide": is_wide, "triangles": triangles, "continues": continues })
    }
}

impl ScenePose {
    fn json(&self, words: &PoseWords) -> Value {
        json!({
            "name": self.name,
            "level": words.level,
            "verdict": words.verdict,
            "reasons": words.reasons,
            "source": self.source.as_ref().map(Coordinates::json),
            "result": self.result.json(),
            "field": self.field.as_ref().map(SceneField::json),
        })
    }
}

/// What a page says of a pose.
#[derive(Clone, Debug, Default)]
pub struct PoseWords {
    /// The class of its verdict in the style sheet.
    pub level: &'static str,
    /// The word for its verdict.
    pub verdict: &'static str,
    /// The reasons of its verdict.
    pub reasons: Vec<String>,
}

impl Scene {
    /// The farthest that rounding moves a position.
    pub fn error(&self) -> f64 {
        let rests = self.meshes.iter().map(|mesh| &mesh.rest);
        let poses = self.poses.iter().flat_map(|pose| pose.source.iter().chain([&pose.result]));
        rests.chain(poses).map(Coordinates::error).fold(0.0, f64::max)
    }

    /// The data for the script; `words` gives what the page says of a pose.
    pub fn json(&self, words: impl Fn(&str) -> PoseWords) -> String {
        let poses: Vec<Value> = self.poses.iter().map(|pose| pose.json(&words(&pose.name))).collect();
        let meshes = self.meshes.each_ref().map(SceneMesh::json);
        let data = json!({ "angles": self.angles, "meshes": meshes, "poses": poses }).to_string();
        // The element around the data ends at the first `</script`, and names may hold anything.
        data.replace('<', "\\u003c")
    }
}

/// Numbers of 16 bits, the low byte first.
fn base64(numbers: &[u16]) -> String {
    BASE64_STANDARD.encode(numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_keeps_to_its_bound() {
        let positions: Vec<[f64; 3]> =
            (0..500).map(f64::from).map(|i| [i.sin() * 3.0, (i * 1.7).cos(), i * 1e-3 + 40.0]).collect();
        let coordinates = Coordinates::new(&positions);
        for (k, position) in positions.iter().enumerate() {
            let distance: f64 = (0..3)
                .map(|axis| {
                    let step = f64::from(coordinates.steps[3 * k + axis]) / 65535.0;
                    (coordinates.low[axis] + step * coordinates.size[axis] - position[axis]).powi(2)
                })
                .sum();
            assert!(distance.sqrt() <= coordinates.error() * (1.0 + 1e-9));
        }
        assert!(coordinates.error() < 1e-4);
    }

    #[test]
    fn what_is_not_finite_does_no_harm() {
        let coordinates = Coordinates::new(&[[f64::NAN; 3], [1.0, 2.0, 3.0], [2.0, 2.0, f64::INFINITY]]);
        assert_eq!((coordinates.low, coordinates.size), ([1.0, 2.0, 3.0], [0.0; 3]));
        assert_eq!(Coordinates::new(&[]).error(), 0.0);
        let field = SceneField::new(&[f64::NAN, 0.0, 5.0, 7.0, -1.0], 5.0, "error, %");
        assert_eq!((field.steps, field.is_over), (vec![65535, 0, 65534, 65534, 0], true));
    }

    #[test]
    fn names_do_not_end_the_data() {
        let pose = ScenePose { name: "</script><b>".into(), ..ScenePose::default() };
        let scene = Scene { poses: vec![pose], ..Scene::default() };
        let json = scene.json(|_| PoseWords::default());
        assert!(!json.contains('<'), "{json}");
        assert_eq!(serde_json::from_str::<Value>(&json).unwrap()["poses"][0]["name"], "</script><b>");
    }
}
