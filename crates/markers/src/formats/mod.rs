//! The notations of marker files, each with its reader and its writer.

mod columns;
pub mod cons;
pub mod json;
mod json_point;
mod json_syntax;
pub mod pp;
mod rows;
pub mod table;
#[cfg(test)]
mod testing;
pub mod wrap;
pub mod yaml;
mod yaml_point;
