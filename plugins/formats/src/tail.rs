//! Files whose head is known only at the end, as one that counts what follows.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use mimesh_core::stage::SequenceFile;

/// Bytes that are held in memory until room is left for the head.
const MAX_HELD: usize = 32 << 20;

/// Bytes that are moved at once.
const BLOCK: usize = 1 << 20;

/// All of a file but its head.
///
/// Bytes are held in memory up to [`MAX_HELD`]. Then they go into the file, behind as much room as the head will probably take.
/// If the head turns out to have another size, the tail is moved.
pub struct Tail {
    file: BufWriter<Box<dyn SequenceFile>>,
    held: Vec<u8>,
    /// Bytes that are left free, once the tail is in the file.
    room: Option<u64>,
    length: u64,
}

impl Tail {
    /// An empty tail of `file`, which is empty too.
    pub fn new(file: Box<dyn SequenceFile>) -> Self {
        Self { file: BufWriter::with_capacity(1 << 16, file), held: Vec::new(), room: None, length: 0 }
    }

    /// The bytes so far.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Whether so much is held that room should be left for the head now.
    pub fn is_full(&self) -> bool {
        self.held.len() >= MAX_HELD
    }

    /// Leaves `room` bytes for the head; what follows goes into the file at once.
    ///
    /// # Errors
    ///
    /// Those of the file.
    pub fn leave_room(&mut self, room: u64) -> io::Result<()> {
        if self.room.is_none() {
            self.file.seek(SeekFrom::Start(room))?;
            self.file.write_all(&std::mem::take(&mut self.held))?;
            self.room = Some(room);
        }
        Ok(())
    }

    /// The room that was left for the head; 0 where none needs to be filled.
    pub fn room(&self) -> u64 {
        self.room.unwrap_or(0)
    }

    /// Completes the file with `head` before all else.
    ///
    /// # Errors
    ///
    /// Those of the file.
    pub fn finish(mut self, head: &[u8]) -> io::Result<()> {
        let size = head.len() as u64;
        if let Some(room) = self.room {
            self.file.flush()?;
            let file = self.file.get_mut();
            shift(&mut **file, room, size, self.length)?;
            file.seek(SeekFrom::Start(0))?;
            file.write_all(head)?;
            return file.flush();
        }
        self.file.write_all(head)?;
        self.file.write_all(&self.held)?;
        self.file.flush()
    }

    /// The file, at its start, without a head.
    ///
    /// # Errors
    ///
    /// Those of the file.
    pub fn into_file(mut self) -> io::Result<Box<dyn SequenceFile>> {
        self.leave_room(0)?;
        let mut file = self.file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.seek(SeekFrom::Start(0))?;
        Ok(file)
    }
}

impl Write for Tail {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match self.room {
            None => {
                self.held.extend_from_slice(bytes);
                bytes.len()
            }
            Some(_) => self.file.write(bytes)?,
        };
        self.length += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Moves the `length` bytes at `from` to `to`, where the file ends with them.
fn shift(file: &mut dyn SequenceFile, from: u64, to: u64, length: u64) -> io::Result<()> {
    if from == to {
        return Ok(());
    }
    let mut block = vec![0; BLOCK.min(usize::try_from(length).unwrap_or(BLOCK))];
    let mut moved = 0;
    while moved < length {
        let count = (length - moved).min(block.len() as u64);
        // From the end that is not written over.
        let at = if to > from { length - moved - count } else { moved };
        let part = &mut block[..count as usize];
        file.seek(SeekFrom::Start(from + at))?;
        file.read_exact(part)?;
        file.seek(SeekFrom::Start(to + at))?;
        file.write_all(part)?;
        moved += count;
    }
    file.set_length(to + length)
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::memory_file::MemoryFile;
    use proptest::prelude::*;

    use super::*;

    fn file(tail: &[u8], parts: usize, room: Option<u64>, head: &[u8]) -> Vec<u8> {
        let file = MemoryFile::default();
        let mut writer = Tail::new(Box::new(file.clone()));
        for (i, part) in tail.chunks(parts).enumerate() {
            writer.write_all(part).unwrap();
            if let (2, Some(room)) = (i, room) {
                writer.leave_room(room).unwrap();
            }
        }
        assert_eq!(writer.length(), tail.len() as u64);
        writer.finish(head).unwrap();
        file.bytes()
    }

    proptest! {
        #[test]
        fn the_head_comes_before_the_tail_whatever_room_was_left(
            tail in prop::collection::vec(any::<u8>(), 0..300),
            head in prop::collection::vec(any::<u8>(), 0..60),
            parts in 1..40_usize,
            room in prop::option::of(0..60_u64),
        ) {
            prop_assert_eq!(file(&tail, parts, room, &head), [head, tail].concat());
        }
    }

    #[test]
    fn a_tail_larger_than_a_block_is_moved_either_way() {
        let tail: Vec<u8> = (0..BLOCK * 5 / 2).map(|i| (i % 251) as u8).collect();
        for (room, head) in [(5, 1000), (1000, 5), (BLOCK as u64 * 2, 3), (3, BLOCK * 2)] {
            let head = vec![7; head];
            assert!(file(&tail, BLOCK / 3, Some(room), &head) == [&head[..], &tail].concat(), "{room}");
        }
    }
}
