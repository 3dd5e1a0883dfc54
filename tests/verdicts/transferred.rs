//! Maps and results of transfers, kept in the target folder since they take long.

use std::{
    collections::hash_map::DefaultHasher,
    fs,
    hash::{Hash, Hasher},
    path::PathBuf,
};

use mimesh::core::{
    mesh::{Surface, SurfacePoint},
    stage::{BindInput, Correspondence, Marker, Proximity, Transfer, TransferPair, TriangleMap},
};
use nalgebra::Point3;

use crate::cases::{Case, Positions};

/// A marker: points of source and target.
type Pair = (SurfacePoint, SurfacePoint);

/// Markers numbered from 0.
pub fn markers(pairs: &[Pair]) -> Vec<Marker> {
    let marker =
        |(k, &(source, target)): (usize, &(SurfacePoint, SurfacePoint))| Marker { name: k.to_string(), source, target };
    pairs.iter().enumerate().map(marker).collect()
}

/// The map and the results of a case whose markers are `pairs`, with a `fault`; `None` if the correspondence refuses them.
pub fn transferred(
    case: &Case,
    surface: &Surface,
    pairs: &[Pair],
    fault: &str,
) -> Option<(TriangleMap, Vec<Positions>)> {
    let files = files(case, pairs, fault);
    let markers = &markers(pairs);
    read(&files, case.target.positions.len()).or_else(|| {
        let tree: Box<dyn Proximity> = serde_json::from_str(r#"{ "type": "spanning_tree" }"#).unwrap();
        let graph = (surface.components().count() > 1).then(|| tree.proximity(surface).unwrap());
        let pair = TransferPair { source: &case.source, target: surface, markers, proximity: graph.as_ref() };
        let correspondence: Box<dyn Correspondence> = serde_json::from_str(case.correspondence).unwrap();
        let transfer: Box<dyn Transfer> = serde_json::from_str(case.transfer).unwrap();
        let map = correspondence.correspond(pair).ok()?;
        let bound = transfer.bind(BindInput::new(pair, &map)).unwrap();
        let result =
            |(_, pose): &(String, Positions)| surface.to_mesh(&bound.transfer(pose).unwrap().positions).unwrap();
        let results: Vec<Positions> = case.poses.iter().map(result).collect();
        write(&files, &map, &results);
        Some((map, results))
    })
}

/// The files of map and results, named by a hash of all that they depend on but the code.
fn files(case: &Case, pairs: &[Pair], fault: &str) -> [PathBuf; 2] {
    let mut hash = DefaultHasher::new();
    format!("{pairs:?} {} {} {fault}", case.name, case.transfer).hash(&mut hash);
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("verdicts");
    let stem = format!("{}-{:016x}", case.name, hash.finish());
    ["map.json", "bin"].map(|ending| folder.join(format!("{stem}.{ending}")))
}

/// The kept map and results of `count` vertices each.
fn read([map, results]: &[PathBuf; 2], count: usize) -> Option<(TriangleMap, Vec<Positions>)> {
    let map = serde_json::from_str(&fs::read_to_string(map).ok()?).ok()?;
    let bytes = fs::read(results).ok()?;
    let number = |bytes: &[u8]| bytes.try_into().map(f64::from_le_bytes).ok();
    let numbers: Vec<f64> = bytes.chunks_exact(8).filter_map(number).collect();
    let points: Positions = numbers.chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2])).collect();
    Some((map, points.chunks_exact(count).map(<[_]>::to_vec).collect()))
}

fn write([map, results]: &[PathBuf; 2], found: &TriangleMap, positions: &[Positions]) {
    let bytes = positions.iter().flatten().flat_map(|p| [p.x, p.y, p.z]).flat_map(f64::to_le_bytes);
    fs::create_dir_all(map.parent().unwrap()).unwrap();
    fs::write(results, bytes.collect::<Vec<u8>>()).unwrap();
    fs::write(map, serde_json::to_string(found).unwrap()).unwrap();
}
