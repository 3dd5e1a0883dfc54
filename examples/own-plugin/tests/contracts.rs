//! Holds the stages of this package to the contracts of their kinds.

use mimesh_core::testkit::contracts;
use own_plugin as _;

#[test]
fn curvature_keeps_the_contract_of_a_sampler() {
    contracts::keeps("sampler", "curvature");
}

#[test]
fn inverse_distance_keeps_the_contract_of_weights() {
    contracts::keeps("weights", "inverse_distance");
}

#[test]
fn exaggerate_keeps_the_contract_of_a_transfer() {
    // Its default takes `gradient`, which mimesh brings.
    use mimesh as _;
    contracts::keeps("transfer", "exaggerate");
}
