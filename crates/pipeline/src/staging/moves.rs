//! Moving files into their places, and back.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use super::{disk, journal::Move, names, place::folder_of};

/// A file on its way. Every step may be repeated.
#[derive(Debug)]
pub(super) struct Moving {
    /// Where it is.
    pub part: PathBuf,
    /// Where it belongs.
    pub place: PathBuf,
    /// Where what was there before is kept.
    kept: PathBuf,
    about: Move,
}

impl Moving {
    /// The move `about` to `place`, of the transaction `identity`.
    pub fn new(identity: &str, place: &Path, about: Move) -> Self {
        let folder = folder_of(place);
        let part = folder.join(names::part(identity, about.place));
        Self { part, kept: folder.join(names::old(identity, about.place)), place: place.into(), about }
    }

    /// Moves the file into its place; what was there is kept.
    pub fn finish(&self) -> io::Result<()> {
        if !self.part.exists() {
            return Ok(());
        }
        if self.about.replaces
            && !self.kept.exists()
            && let Ok(before) = fs::metadata(&self.place)
        {
            // A file that is replaced keeps who may read it.
            let _ = fs::set_permissions(&self.part, before.permissions());
            disk::keep(&self.place, &self.kept)?;
        }
        disk::rename(&self.part, &self.place)
    }

    /// Puts back what was in the place, and removes the file.
    pub fn undo(&self) -> io::Result<()> {
        if self.about.replaces {
            if self.kept.exists() {
                disk::rename(&self.kept, &self.place)?;
                // Two names of one file stay when one is moved to the other.
                disk::remove(&self.kept)?;
            }
        } else if !self.part.exists() && self.is_in_place() {
            disk::remove(&self.place)?;
        }
        disk::remove(&self.part)
    }

    /// Removes what was kept.
    pub fn clean_up(&self) -> io::Result<()> {
        disk::remove(&self.kept)
    }

    /// Whether the file is whole, here or in its place.
    pub fn can_finish(&self) -> bool {
        match fs::metadata(&self.part) {
            Ok(part) => part.len() == self.about.bytes,
            Err(_) => self.is_in_place(),
        }
    }

    fn is_in_place(&self) -> bool {
        let has_hash = || {
            let mut hasher = blake3::Hasher::new();
            hasher.update_reader(File::open(&self.place)?)?;
            io::Result::Ok(hasher.finalize().to_hex().as_str() == self.about.blake3)
        };
        fs::metadata(&self.place).is_ok_and(|found| found.is_file() && found.len() == self.about.bytes)
            && has_hash().unwrap_or(false)
    }
}
