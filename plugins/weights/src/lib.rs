//! Weights: ways to spread the influence of handles over a surface.
