//! Samples: meshes with poses that are made, not read, so that pipelines run without any file.

pub mod quadruped;
