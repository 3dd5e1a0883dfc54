//! Files in memory.

use std::{
    io::{self, Cursor, Read, Seek, SeekFrom, Write},
    sync::{Arc, Mutex},
};

use crate::stage::SequenceFile;

/// A file in memory, which can be looked at while a writer has it.
#[derive(Clone, Debug, Default)]
pub struct MemoryFile(Arc<Mutex<Cursor<Vec<u8>>>>);

impl MemoryFile {
    /// What has been written.
    ///
    /// # Panics
    ///
    /// If a writer panicked.
    pub fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap().get_ref().clone()
    }
}

impl Read for MemoryFile {
    fn read(&mut self, part: &mut [u8]) -> io::Result<usize> {
        self.0.lock().unwrap().read(part)
    }
}

impl Write for MemoryFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for MemoryFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.lock().unwrap().seek(to)
    }
}

impl SequenceFile for MemoryFile {
    fn set_length(&mut self, length: u64) -> io::Result<()> {
        self.0.lock().unwrap().get_mut().resize(length as usize, 0);
        Ok(())
    }
}
