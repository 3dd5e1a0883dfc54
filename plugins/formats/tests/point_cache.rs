//! PC2 and MDD: their bytes, times, names and damage; USD: its text.

mod support;

use std::{
    borrow::Cow,
    path::Path,
    sync::{Arc, Mutex},
};

use mimesh_core::{
    mesh::{ClipTime, Mesh, MeshSequence},
    stage::{
        BytesInput, ClipChoice, ClipTimes, FileInput, Format, MeshWriter, PoseChoice, ReadAt, RestShape, Selection,
        SequenceFormat,
    },
    testkit::memory_file::MemoryFile,
};
use mimesh_formats::{Mdd, Pc2, Usda};
use nalgebra::{Point3, Vector3};
use support::{distance, gltf::names, grid, message, read};

/// A grid of quads, and frames that move it by 1 along x each; f32 holds them exactly.
fn moving(frames: usize) -> (Mesh, Vec<Vec<Point3<f64>>>) {
    let mut mesh = grid(3);
    mesh.positions.iter_mut().for_each(|p| p.z = 0.25);
    let frame = |i: usize| mesh.positions.iter().map(|p| p + Vector3::x() * i as f64).collect();
    let frames = (0..frames).map(frame).collect();
    (mesh, frames)
}

/// The file that a format writes, and its warnings; `times` are seconds in the clip `Run`.
fn written(
    format: &dyn Format,
    mesh: &Mesh,
    frames: &[Vec<Point3<f64>>],
    times: Option<&[f64]>,
) -> (Vec<u8>, Vec<String>) {
    let Some(MeshWriter::Sequence(sequence)) = format.writer() else { panic!("one file takes all poses") };
    let file = MemoryFile::default();
    let mut writer = sequence.start(mesh, frames.len(), Box::new(file.clone())).unwrap();
    for (index, frame) in frames.iter().enumerate() {
        let time = times.map(|times| ClipTime { clip: "Run".into(), seconds: times[index] });
        writer.add("pose", time.as_ref(), frame).unwrap();
    }
    let warnings = writer.warnings();
    writer.finish().unwrap();
    (file.bytes(), warnings)
}

fn seconds(sequence: &MeshSequence) -> Vec<f64> {
    sequence.poses.iter().map(|pose| pose.time.as_ref().unwrap().seconds).collect()
}

#[test]
fn pc2_has_the_layout_that_other_programs_read() {
    let (mesh, frames) = moving(3);
    let (bytes, warnings) = written(&Pc2::default(), &mesh, &frames, Some(&[0.5, 1.0, 1.5]));
    let mut expected = b"POINTCACHE2\0".to_vec();
    expected.extend([1_i32, 9].map(i32::to_le_bytes).concat());
    // The first frame, and frames a sample, at 24 a second.
    expected.extend([12_f32, 12.0].map(f32::to_le_bytes).concat());
    expected.extend(3_i32.to_le_bytes());
    expected.extend(frames.iter().flatten().flat_map(|p| p.iter().copied()).flat_map(|x| (x as f32).to_le_bytes()));
    assert_eq!((bytes, warnings), (expected, vec![]));
}

#[test]
fn mdd_has_the_layout_that_other_programs_read() {
    let (mesh, frames) = moving(2);
    let (bytes, _) = written(&Mdd::default(), &mesh, &frames, Some(&[0.5, 2.0]));
    let mut expected = [2_i32, 9].map(i32::to_be_bytes).concat();
    expected.extend([0.5_f32, 2.0].map(f32::to_be_bytes).concat());
    expected.extend(frames.iter().flatten().flat_map(|p| p.iter().copied()).flat_map(|x| (x as f32).to_be_bytes()));
    assert_eq!(bytes, expected);
}

#[test]
fn frames_come_back_with_times_and_names() {
    let (mesh, frames) = moving(3);
    for (format, name) in [(&Pc2::default() as &dyn Format, "run.pc2"), (&Mdd::default(), "run.mdd")] {
        let (bytes, _) = written(format, &mesh, &frames, Some(&[0.5, 1.0, 1.5]));
        let sequence = read(format, name, &bytes).unwrap();
        assert_eq!(names(&sequence), ["run-00", "run-01", "run-02"]);
        assert_eq!(seconds(&sequence), [0.5, 1.0, 1.5]);
        assert_eq!(sequence.rest.positions, frames[0]);
        sequence
            .poses
            .iter()
            .zip(&frames)
            .for_each(|(pose, frame)| assert_eq!(&*pose.positions.get().unwrap(), &frame[..]));
        assert!(sequence.rest.polygons.is_empty(), "a cache has no polygons");
        // Between samples the vertices move evenly.
        let choice =
            ClipChoice { clips: vec!["run".into()], times: ClipTimes::PerSecond(4.0), range: Some([1.0, 1.5]) };
        let choice = Selection { poses: PoseChoice::Clips(choice), ..Selection::default() };
        let sequence = format.read(&BytesInput::new(name, &bytes[..]), &choice).unwrap();
        assert_eq!(seconds(&sequence), [1.0, 1.25, 1.5]);
        let between: Vec<_> = frames[1].iter().zip(&frames[2]).map(|(a, b)| nalgebra::center(a, b)).collect();
        assert!(distance(&sequence.poses[1].positions.get().unwrap(), &between) < 1e-15);
        let rest = RestShape::Clip { name: "run".into(), seconds: 1.5 };
        let late =
            format.read(&BytesInput::new(name, &bytes[..]), &Selection { rest, ..Selection::default() }).unwrap();
        assert_eq!(late.rest.positions, frames[2]);
    }
}

/// A file that is read by parts alone, and is cut to `length` while it is used.
#[derive(Debug)]
struct ByParts {
    bytes: BytesInput,
    length: Arc<Mutex<usize>>,
}

impl FileInput for ByParts {
    fn path(&self) -> &Path {
        self.bytes.path()
    }

    fn contents(&self) -> mimesh_core::Result<Cow<'_, [u8]>> {
        panic!("a file as large as this is not held")
    }

    fn open(&self) -> mimesh_core::Result<Box<dyn ReadAt>> {
        Ok(Box::new(Self { bytes: self.bytes.clone(), length: self.length.clone() }))
    }

    fn referenced(&self, reference: &str) -> mimesh_core::Result<Vec<u8>> {
        self.bytes.referenced(reference)
    }
}

impl ReadAt for ByParts {
    fn length(&self) -> u64 {
        *self.length.lock().unwrap() as u64
    }

    fn read_at(&self, offset: u64, part: &mut [u8]) -> mimesh_core::Result<()> {
        let now = self.bytes.contents[..*self.length.lock().unwrap()].to_vec();
        BytesInput::new(self.bytes.path(), now).read_at(offset, part)
    }
}

#[test]
fn frames_are_read_when_they_are_asked_for_and_one_that_is_gone_is_an_error() {
    let (mesh, frames) = moving(5);
    for (format, name) in [(&Pc2::default() as &dyn Format, "run.pc2"), (&Mdd::default(), "run.mdd")] {
        let (bytes, _) = written(format, &mesh, &frames, None);
        let length = Arc::new(Mutex::new(bytes.len()));
        let input = ByParts { bytes: BytesInput::new(name, bytes), length: length.clone() };
        let sequence = format.read(&input, &Selection::default()).unwrap();
        assert_eq!(&*sequence.poses[4].positions.get().unwrap(), &frames[4][..]);
        // One byte of the last frame is lost.
        *length.lock().unwrap() -= 1;
        assert_eq!(&*sequence.poses[3].positions.get().unwrap(), &frames[3][..]);
        let error = sequence.poses[4].positions.get().unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn poses_without_times_are_frames_in_their_order() {
    let (mesh, frames) = moving(2);
    for (format, name) in [(&Pc2::default() as &dyn Format, "a.pc2"), (&Mdd::default(), "a.mdd")] {
        let (bytes, warnings) = written(format, &mesh, &frames, None);
        assert_eq!(warnings, ["a point cache has no names: the poses are its frames, in their order"]);
        let sequence = read(format, name, &bytes).unwrap();
        // An f32 of 1/24.
        assert!((seconds(&sequence)[1] - 1.0 / 24.0).abs() < 1e-8);
        // A second clip starts again at 0.
        let (bytes, warnings) = written(format, &mesh, &frames, Some(&[0.0, 0.0]));
        assert_eq!(warnings, ["a point cache is one clip: the clips follow one another in it"]);
        assert!((seconds(&read(format, name, &bytes).unwrap())[1] - 1.0 / 24.0).abs() < 1e-8);
    }
}

#[test]
fn uneven_times_are_told_where_they_are_lost() {
    let (mesh, frames) = moving(3);
    let (_, warnings) = written(&Pc2::default(), &mesh, &frames, Some(&[0.0, 0.25, 1.0]));
    assert_eq!(warnings, ["PC2 has evenly spaced frames: the times of the poses are not kept; mdd keeps them"]);
    let (bytes, warnings) = written(&Mdd::default(), &mesh, &frames, Some(&[0.0, 0.25, 1.0]));
    assert_eq!((warnings, seconds(&read(&Mdd::default(), "a.mdd", &bytes).unwrap())), (vec![], vec![0.0, 0.25, 1.0]));
}

#[test]
fn damage_is_an_error_that_names_the_file() {
    let (mesh, frames) = moving(2);
    let (pc2, _) = written(&Pc2::default(), &mesh, &frames, None);
    let (mdd, _) = written(&Mdd::default(), &mesh, &frames, None);
    let hint = "\nthe file is damaged or cut short: export it again";
    let pc2_error = |bytes: &[u8]| message(&read(&Pc2::default(), "a.pc2", bytes).unwrap_err());
    let mdd_error = |bytes: &[u8]| message(&read(&Mdd::default(), "a.mdd", bytes).unwrap_err());
    let cut = "2 samples of 9 points take 248 bytes, the file has 247";
    assert_eq!(pc2_error(&pc2[..247]), format!("a.pc2: {cut}{hint}"));
    assert_eq!(pc2_error(&pc2[..20]), format!("a.pc2: the header takes 32 bytes, the file has 20{hint}"));
    assert_eq!(pc2_error(b"v 0 0 0\n"), format!("a.pc2: not a PC2: it does not start with `POINTCACHE2`{hint}"));
    assert_eq!(mdd_error(&mdd[..4]), format!("a.mdd: the header takes 8 bytes, the file has 4{hint}"));
    assert_eq!(mdd_error(&[0xff; 64]), format!("a.mdd: not an MDD: -1 frames of -1 points{hint}"));
    assert_eq!(mdd_error(&[0x7f; 64]), format!("a.mdd: 2139062143 frames have 14 times: expected one each{hint}"));
    for end in 0..mdd.len() {
        assert!(mdd_error(&mdd[..end]).starts_with("a.mdd: "));
    }
    for (place, value) in [(12, 2_u8), (19, 0xff), (27, 0x80), (31, 0x7f)] {
        let mut damaged = pc2.clone();
        damaged[place] = value;
        assert!(pc2_error(&damaged).starts_with("a.pc2: "), "byte {place}");
    }
}

#[test]
fn positions_beyond_f32_are_refused() {
    let (mesh, mut frames) = moving(1);
    frames[0][3].y = 1e39;
    let mut writer = Pc2::default().start(&mesh, 1, Box::<MemoryFile>::default()).unwrap();
    let error = writer.add("far", None, &frames[0]).unwrap_err().to_string();
    assert_eq!(error, "pose `far` has positions that are not finite as 32-bit numbers");
}

#[test]
fn usd_has_a_time_sample_a_pose() {
    let mut mesh = Mesh::from_triangles(
        vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 0.5, 0.0)],
        &[[0, 1, 2]],
    );
    let frames = [mesh.positions.clone(), mesh.positions.iter().map(|p| p * 2.0).collect()];
    mesh.polygons.push(&[0, 1]);
    let (text, warnings) = written(&Usda::default(), &mesh, &frames, Some(&[0.5, 1.0]));
    assert_eq!(warnings, ["not kept in USD: polygons of fewer than three corners"]);
    let expected = "#usda 1.0\n(\n    defaultPrim = \"target\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n    \
        timeCodesPerSecond = 24\n    framesPerSecond = 24\n    startTimeCode = 12\n    endTimeCode = 24\n)\n\n\
        def Xform \"target\"\n{\n    def Mesh \"mesh\"\n    {\n        uniform token subdivisionScheme = \"none\"\n        \
        int[] faceVertexCounts = [3]\n        int[] faceVertexIndices = [0, 1, 2]\n        \
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 0.5, 0)]\n        point3f[] points.timeSamples = {\n            \
        12: [(0, 0, 0), (1, 0, 0), (0, 0.5, 0)],\n            24: [(0, 0, 0), (2, 0, 0), (0, 1, 0)],\n        }\n    }\n}\n";
    assert_eq!(String::from_utf8(text).unwrap(), expected);
}
