//! The notations of marker files, each with its reader and its writer.

pub mod amira;
mod columns;
pub mod cons;
pub mod fcsv;
pub mod json;
mod json_point;
mod json_syntax;
mod markups;
pub mod pp;
pub mod pts;
mod rows;
pub mod table;
#[cfg(test)]
mod testing;
pub mod wrap;
pub mod yaml;
mod yaml_point;
