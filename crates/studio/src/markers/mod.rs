//! The document of markers that all pages share: pairs, edits that are merged by pair, a history, and the file that holds it.
//!
//! In reading order: [`pair`], [`edit`], [`document`], [`apply`](mod@apply), [`history`], [`outside`], [`mod@file`], [`view`], [`store`].

pub mod apply;
pub mod document;
pub mod edit;
pub mod file;
pub mod history;
pub mod outside;
pub mod pair;
pub mod store;
#[cfg(test)]
mod tests;
pub mod view;

pub use document::MarkerDocument;
pub use edit::{Edit, EditResult, Op};
pub use pair::{Origin, Pair, Point, Side, Status};
pub use store::MarkerStore;
pub use view::{DiskState, MarkersView};
