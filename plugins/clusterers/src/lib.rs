//! Clusterers: ways to divide a surface into regions that move about rigidly.
