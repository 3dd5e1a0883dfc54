//! The Khronos validator finds no fault with what is written that the input did not have.

use std::{collections::BTreeSet, path::Path, process::Command};

use mimesh_core::testkit::data::{data, missing};
use serde_json::Value;

use super::{
    build::{twisted, write},
    evaluate::load,
};
use crate::{Glb, PoseAnimation};

/// The errors and warnings in a GLB, by their code; `None` where the validator is missing.
fn faults(glb: &[u8]) -> Option<BTreeSet<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/gltf-validator");
    if !folder.join("node_modules/gltf-validator").exists() {
        missing("gltf-validator", "run `npm ci --prefix tests/gltf-validator`");
        return None;
    }
    let file = tempfile::Builder::new().suffix(".glb").tempfile().unwrap();
    std::fs::write(file.path(), glb).unwrap();
    let output = Command::new("node").arg(folder.join("validate.mjs")).arg(file.path()).output().unwrap();
    let messages: Vec<Value> = serde_json::from_slice(&output.stderr).unwrap_or_default();
    // Without messages the counts alone must say so.
    assert!(!messages.is_empty() || output.stdout.starts_with(b"{\"errors\":0,\"warnings\":0"), "{output:?}");
    let severe = messages.iter().filter(|message| message["severity"].as_u64().unwrap() < 2);
    Some(severe.map(|message| format!("{} {}", message["code"], message["message"])).collect())
}

#[test]
fn patched_files_have_no_faults_of_their_own() {
    for path in [
        "khronos-gltf/Fox.glb",
        "khronos-gltf/CesiumMan.glb",
        "khronos-gltf/BrainStem.glb",
        "khronos-gltf/RiggedSimple.glb",
        "robot/RobotExpressive.glb",
        "reports/g_avatar.glb",
        "reports/g_ok.vrm",
        "reports/g_weightanim.glb",
        "reports/g_nodeweights.glb",
        "reports/g_two_unnamed.glb",
        "reports/g_skin_two.glb",
    ] {
        let Some(path) = data(path) else { continue };
        let before = std::fs::read(&path).unwrap();
        let mesh = load(&before);
        let mut one = mesh.positions.clone();
        one[5].y += 0.25 * mesh.diagonal();
        let poses = [("twist-1", None, twisted(&mesh)), ("twist-2", None, one)];
        let glb = Glb { animation: PoseAnimation::Play, ..Glb::default() };
        let (after, _) = write(&glb, &mesh, &poses);
        let (Some(old), Some(new)) = (faults(&before), faults(&after)) else { return };
        assert!(new.is_subset(&old), "{}: {:?}", path.display(), new.difference(&old));
    }
}
