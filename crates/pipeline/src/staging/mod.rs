//! Results that appear together: every file of a run is in its place, or all that was there before still is.
//!
//! A [`Transaction`] writes files beside their places under names of its own, and [`commit`](Transaction::commit) moves them. A journal
//! in the folder of the last place lists the places before anything is written, and what is to be moved before anything is moved. It is
//! locked as long as its writer lives. So whoever next begins a transaction with one of these places finds the journal of one that was
//! killed, and finishes or undoes it. [`survey`] looks without doing anything.
//!
//! Others may do anything meanwhile. What somebody has edited after a run was killed is set aside under a name of its own. A temporary
//! file that is gone ends the commit as it began. A journal from a stranger moves nothing elsewhere.
//!
//! Names of temporary files begin with `.mimesh-` and an identity that was drawn at random. Processes of several machines or containers
//! may write into one folder. On a file system without locks a transaction that was killed is taken for one that lives.

mod disk;
mod failure;
mod folder_lock;
mod journal;
mod moves;
mod names;
mod owner;
mod path_text;
mod place;
mod pointer;
mod recovery;
mod registry;
mod staged;
mod survey;
mod transaction;
mod write_all;

#[cfg(test)]
mod strangers;
#[cfg(test)]
mod tests;

pub use place::not_a_file;
pub use registry::{discard_all_and_exit, discard_all_before_exit};
pub use staged::{Staged, WrittenFile};
pub use survey::{Interrupted, Survey, survey};
pub use transaction::Transaction;
pub use write_all::{Written, write_all};
