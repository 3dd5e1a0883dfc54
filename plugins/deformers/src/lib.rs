//! Deformers: ways to find the maps of handles that bring a surface to a pose.
