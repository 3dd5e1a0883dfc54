//! Whole files through the writer: what changes, what stays, and where vertices end up.

mod animations;
mod build;
mod built;
mod difference;
mod evaluate;
mod real_files;
