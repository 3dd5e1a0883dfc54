//! Holds the stage to the contract of its kind.

// Links the stages that mimesh brings, for stages that ask for one of them.
use mimesh as _;
use mimesh_core::testkit::contracts;
use my_stage as _;

#[test]
fn it_keeps_its_contract() {
    contracts::keeps("my_kind", "my_stage");
}
