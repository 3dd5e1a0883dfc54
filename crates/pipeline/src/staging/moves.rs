//! Moving files into their places, and back.

use std::{
    fs::{self, File},
    io::{self, ErrorKind},
    path::{Path, PathBuf},
};

use super::{
    disk,
    journal::{Before, Move},
    names,
    place::{folder_of, not_a_file},
};

/// Names that are tried for a file that is set aside.
const MAX_ASIDE: usize = 1000;

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

    /// Whether the file waits for its move as it was written: others may have removed or changed it.
    pub fn is_ready(&self) -> bool {
        fs::symlink_metadata(&self.part).is_ok_and(|found| found.is_file() && found.len() == self.about.bytes)
    }

    /// Moves the file into its place; what was there is kept.
    ///
    /// # Errors
    ///
    /// Those of the system, and that something else has come to either name meanwhile.
    pub fn commit(&self) -> io::Result<()> {
        if !self.is_ready() {
            return Err(io::Error::other("its temporary file was removed or changed by another program"));
        }
        let is_link = fs::symlink_metadata(&self.place).is_ok_and(|found| found.is_symlink());
        if let Some(kind) = if is_link { Some("a link") } else { not_a_file(&self.place) } {
            return Err(io::Error::other(format!("there is {kind} of that name now")));
        }
        if !self.about.replaces && exists(&self.place)? {
            return Err(io::Error::other("another program has just made a file of that name"));
        }
        self.replace()
    }

    /// Moves the file into its place, if it is not there yet, for a transaction that was killed. What is neither the old file nor the
    /// new one is set aside; its new name is given.
    pub fn finish(&self) -> io::Result<Option<PathBuf>> {
        if !exists(&self.part)? {
            return Ok(None);
        }
        let aside = self.set_aside()?;
        self.replace()?;
        Ok(aside)
    }

    fn replace(&self) -> io::Result<()> {
        if self.about.replaces
            && !exists(&self.kept)?
            && let Ok(before) = fs::metadata(&self.place)
        {
            // A file that is replaced keeps who may read it.
            let _ = fs::set_permissions(&self.part, before.permissions());
            disk::keep(&self.place, &self.kept)?;
        }
        disk::rename(&self.part, &self.place)
    }

    /// Puts back what was in the place, and removes the file. What is neither the old file nor the new one is set aside, or stays where
    /// nothing has to be put back; its new name is given.
    pub fn undo(&self) -> io::Result<Option<PathBuf>> {
        let mut aside = None;
        if self.about.replaces {
            // Only a file was ever kept; a link would lead the next run elsewhere.
            if exists(&self.kept)? && fs::symlink_metadata(&self.kept)?.is_file() {
                if !are_same(&self.kept, &self.place) {
                    aside = self.set_aside()?;
                }
                disk::rename(&self.kept, &self.place)?;
                // Two names of one file stay when one is moved to the other.
                disk::remove(&self.kept)?;
            }
        } else if !exists(&self.part)? && self.is_in_place() {
            disk::remove(&self.place)?;
        }
        disk::remove(&self.part)?;
        Ok(aside)
    }

    /// Removes what was kept.
    pub fn clean_up(&self) -> io::Result<()> {
        disk::remove(&self.kept)
    }

    /// Whether the file is whole, here or in its place.
    pub fn can_finish(&self) -> bool {
        match exists(&self.part) {
            Ok(true) => self.is_whole(&self.part),
            _ => self.is_in_place(),
        }
    }

    fn is_in_place(&self) -> bool {
        self.is_whole(&self.place)
    }

    /// Whether `file` has the size and the contents that were written.
    fn is_whole(&self, file: &Path) -> bool {
        let has_hash = || {
            let mut hasher = blake3::Hasher::new();
            hasher.update_reader(File::open(file)?)?;
            io::Result::Ok(hasher.finalize().to_hex().as_str() == self.about.blake3)
        };
        fs::symlink_metadata(file).is_ok_and(|found| found.is_file() && found.len() == self.about.bytes)
            && has_hash().unwrap_or(false)
    }

    /// Gives what is in the place another name, if it is neither the old file nor the new one: somebody has edited it since.
    fn set_aside(&self) -> io::Result<Option<PathBuf>> {
        let found = match fs::symlink_metadata(&self.place) {
            Ok(found) => found,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        if self.about.before.is_some_and(|before| Before::of(&found) == Some(before)) || self.is_in_place() {
            return Ok(None);
        }
        for number in 1..=MAX_ASIDE {
            let aside = self.place.with_file_name(names::edited(&self.place, number));
            if are_same(&aside, &self.place) {
                return Ok(Some(aside));
            }
            if !exists(&aside)? {
                disk::keep(&self.place, &aside)?;
                return Ok(Some(aside));
            }
        }
        Err(io::Error::new(ErrorKind::AlreadyExists, "it was edited, and all names for keeping it are taken"))
    }
}

/// Whether there is something of this name, be it a link that leads nowhere.
fn exists(path: &Path) -> io::Result<bool> {
    match fs::symlink_metadata(path) {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Whether two names are of one file.
#[cfg(unix)]
fn are_same(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let of = |path: &Path| fs::symlink_metadata(path).ok().map(|found| (found.dev(), found.ino()));
    of(a).is_some_and(|found| of(b) == Some(found))
}

/// Files have one name, as far as can be told.
#[cfg(not(unix))]
fn are_same(_: &Path, _: &Path) -> bool {
    false
}
