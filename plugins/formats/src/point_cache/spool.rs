//! Poses on their way into a point cache, behind room for the header, which counts them.

use std::io::Write;

use mimesh_core::{
    Error,
    mesh::ClipTime,
    stage::{SequenceFile, WriteError},
};
use nalgebra::Point3;

use crate::tail::Tail;

/// Positions in a file, with their times; memory grows by eight bytes a pose.
pub struct Spool {
    tail: Tail,
    /// The bytes of a pose.
    encoded: Vec<u8>,
    encode: fn(f32) -> [u8; 4],
    /// Positions a sample.
    pub points: usize,
    /// The seconds of each sample, ascending.
    pub times: Vec<f64>,
    step: f64,
    names: usize,
    restarts: usize,
}

impl Spool {
    /// Takes poses of `points` vertices into `file`, behind `header` bytes; one without a time comes `step` seconds after the last.
    ///
    /// # Errors
    ///
    /// Those of the file, and [`Error::Data`] for more vertices than the layouts count.
    pub fn new(
        file: Box<dyn SequenceFile>,
        header: usize,
        points: usize,
        step: f64,
        encode: fn(f32) -> [u8; 4],
    ) -> Result<Self, WriteError> {
        if i32::try_from(points).is_err() {
            let message = format!("{points} vertices: a point cache takes at most {}", i32::MAX);
            return Err(Error::data(message, "write glb, or a part of the mesh").into());
        }
        let mut tail = Tail::new(file);
        tail.leave_room(header as u64)?;
        Ok(Self { tail, encoded: Vec::new(), encode, points, times: Vec::new(), step, names: 0, restarts: 0 })
    }

    /// Appends a pose.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the count differs from the mesh, [`Error::Data`] for positions beyond f32, and those of the file.
    pub fn add(&mut self, name: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        Error::check_shape("posed target vertices (#V)", self.points, positions.len())?;
        self.encoded.clear();
        for number in positions.iter().flat_map(|position| position.iter()) {
            let number = *number as f32;
            if !number.is_finite() {
                let message = format!("pose `{name}` has positions that are not finite as 32-bit numbers");
                return Err(Error::data(message, "give the mesh in a larger unit, nearer to the origin").into());
            }
            self.encoded.extend_from_slice(&(self.encode)(number));
        }
        self.tail.write_all(&self.encoded)?;
        let next = self.times.last().map(|last| last + self.step);
        let seconds = match (time, next) {
            (Some(time), None) => time.seconds,
            (Some(time), Some(next)) if time.seconds > next - self.step => time.seconds,
            (Some(_), Some(next)) => {
                self.restarts += 1;
                next
            }
            (None, next) => {
                self.names += 1;
                next.unwrap_or(0.0)
            }
        };
        self.times.push(seconds);
        Ok(())
    }

    /// Sentences about what the file does not keep.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.names > 0 {
            warnings.push("a point cache has no names: the poses are its frames, in their order".into());
        }
        if self.restarts > 0 {
            warnings.push("a point cache is one clip: the clips follow one another in it".into());
        }
        warnings
    }

    /// Completes the file with its header.
    ///
    /// # Errors
    ///
    /// Those of the file.
    pub fn finish(self, header: &[u8]) -> Result<(), WriteError> {
        Ok(self.tail.finish(header)?)
    }

    /// A count for a header.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if it is too large.
    pub fn count(count: usize) -> Result<i32, WriteError> {
        i32::try_from(count).map_err(|_| {
            let message = format!("{count} poses: a point cache takes at most {}", i32::MAX);
            Error::data(message, "write fewer poses a file").into()
        })
    }
}
