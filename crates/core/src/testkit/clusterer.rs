//! The contract of clusterers.

use super::{
    deformer::soft_weights,
    support::{bent_bar, one_thread, twisted, with_defects},
};
use crate::{
    mesh::Surface,
    stage::{Clusterer, Regions},
};

/// The contract of [`Clusterer`], on a sound surface and on one with defects, with poses and without.
pub fn clusterer(name: &str, stage: &dyn Clusterer) {
    for surface in [bent_bar(), with_defects(bent_bar())] {
        let poses = [twisted(&surface, 1.0), twisted(&surface, -2.0)];
        for poses in [&poses[..], &[]] {
            let run = |handles: &[usize]| {
                let bound = stage.bind(&surface, poses).unwrap_or_else(|error| panic!("{name}: {error}"));
                let weights = soft_weights(&surface, handles);
                bound.cluster(&weights).unwrap_or_else(|error| panic!("{name}: {error}"))
            };
            for handles in [&[5, 40, 77, 60, 21][..], &[9], &[5, 40, 40, 40]] {
                let regions = run(handles);
                check_laws(name, &surface, &regions, handles.len());
                let same = |other: Regions| other.of_vertex == regions.of_vertex && other.count == regions.count;
                assert!(same(run(handles)), "{name}: other regions the next time");
                assert!(same(one_thread(|| run(handles))), "{name}: other regions on one thread");
            }
        }
        let bound = stage.bind(&surface, &poses).unwrap_or_else(|error| panic!("{name}: {error}"));
        let weights = soft_weights(&surface, &[5, 40, 77]);
        assert!(bound.cluster(&weights.clone().remove_row(0)).is_err(), "{name}: takes weights of another surface");
        assert!(stage.bind(&surface, &[poses[0][1..].to_vec()]).is_err(), "{name}: takes a pose with a vertex too few");
    }
}

fn check_laws(name: &str, surface: &Surface, regions: &Regions, handles: usize) {
    regions.check(surface.vertex_count()).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(regions.count <= handles, "{name}: {} regions of {handles} handles", regions.count);
    for region in 0..regions.count as u32 {
        assert!(regions.of_vertex.contains(&region), "{name}: region {region} is empty");
    }
}
