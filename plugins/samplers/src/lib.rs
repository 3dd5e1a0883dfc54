//! Samplers: ways to spread points over a surface.
