//! The server: who may ask, what is answered, and how much of it.

pub mod body;
pub mod connections;
pub mod page;
pub mod security;
