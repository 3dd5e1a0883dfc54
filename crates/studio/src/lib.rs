//! The studio: a server for looking at two meshes, correcting their markers and watching the target move, in the browser.
//!
//! `docs/studio-protocol.md` is what pages and the server agree on. A [`Server`] holds one [`project`]: meshes, a document of
//! [`markers`], a [`pipeline`], and [`live`] results of the pose that is looked at. The crate knows no command line.
//!
//! In reading order: [`error`], [`container`], [`folders`], [`meshes`], [`markers`], [`pipeline`], [`project`], [`job`], [`jobs`],
//! [`live`], [`studio`], [`attend`], [`propose`], [`run`], [`routes`], [`web`], [`server`].

pub mod attend;
pub mod cancel;
pub mod checks;
pub mod container;
pub mod durable;
pub mod error;
pub mod events;
pub mod folders;
pub mod job;
pub mod jobs;
pub mod live;
pub mod markers;
pub mod masks;
pub mod meshes;
pub mod next;
pub mod order;
pub mod pipeline;
pub mod project;
pub mod propose;
mod regular;
pub mod routes;
pub mod run;
pub mod scalars;
pub mod server;
pub mod shared;
pub mod studio;
pub mod summary;
pub mod web;
pub mod worst;

pub use server::{Server, Start, StudioOptions};
