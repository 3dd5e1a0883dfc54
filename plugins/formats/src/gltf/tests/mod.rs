//! Whole files through the writers: what changes, what stays, and where vertices end up.

mod animations;
mod buffers;
mod build;
mod built;
mod difference;
mod empties;
mod evaluate;
mod plain;
mod real_files;
mod round_trip;
mod transforms;
mod validator;
mod vrm;
