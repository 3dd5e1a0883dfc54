//! What is done to files while they are moved into place. Tests let each step fail, or the process die before it.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::Path,
};

/// Moves a file; what has the name `to` is replaced.
pub(super) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fault::step()?;
    fs::rename(from, to)
}

/// Gives the file at `place` a second name, or its only one where files cannot have two.
pub(super) fn keep(place: &Path, kept: &Path) -> io::Result<()> {
    fault::step()?;
    match fs::hard_link(place, kept) {
        Err(error) if !matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::AlreadyExists) => {
            fs::rename(place, kept)
        }
        done => done,
    }
}

/// Removes a file, which may be gone.
pub(super) fn remove(file: &Path) -> io::Result<()> {
    fault::step()?;
    match fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Adds a line to a journal.
pub(super) fn append(journal: &mut File, line: &[u8]) -> io::Result<()> {
    if let Err(error) = fault::step() {
        // A disk that is full takes the beginning.
        journal.write_all(&line[..line.len() / 2])?;
        return Err(error);
    }
    journal.write_all(line)
}

/// Waits until a file is on the disk.
pub(super) fn sync(file: &File) -> io::Result<()> {
    fault::step()?;
    file.sync_all()
}

/// Waits until the names in a folder are on the disk, where the system can tell.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    fault::step()?;
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(not(test))]
mod fault {
    /// Nothing fails by itself.
    #[expect(clippy::unnecessary_wraps, reason = "in tests steps fail")]
    pub(super) fn step() -> std::io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod fault {
    use std::{
        cell::Cell,
        io::{Error, Result},
    };

    /// What happens at a step.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Fault {
        /// The step fails.
        Fails,
        /// The process dies before it, without a last word.
        Dies,
    }

    thread_local! {
        static PLANNED: Cell<Option<(usize, Fault)>> = const { Cell::new(None) };
        static STEPS: Cell<usize> = const { Cell::new(0) };
    }

    /// Lets this thread's step `number`, from 0, go wrong; counting begins anew.
    pub fn plan(fault: Option<(usize, Fault)>) {
        PLANNED.set(fault);
        STEPS.set(0);
    }

    /// The steps of this thread since the last plan.
    pub fn steps() -> usize {
        STEPS.get()
    }

    pub(super) fn step() -> Result<()> {
        let number = STEPS.get();
        STEPS.set(number + 1);
        match PLANNED.get() {
            Some((at, Fault::Fails)) if at == number => Err(Error::other("a fault that a test planned")),
            Some((at, Fault::Dies)) if at == number => std::process::abort(),
            _ => Ok(()),
        }
    }
}
