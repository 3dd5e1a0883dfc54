//! Holds every registered implementation of every stage to its contract.

use std::{collections::HashSet, path::PathBuf};

use mimesh::core::{
    plugin::{self, instances},
    stage::{
        Clusterer, Correspondence, Deformer, Format, Generator, KeyPoints, Metric, Proximity, Sampler, Transfer,
        Weights,
    },
    testkit::contracts,
};

#[test]
fn every_implementation_describes_itself_and_its_settings() {
    assert!(plugin::all().len() > 8, "the bundled stages are linked");
    plugin::all().into_iter().for_each(contracts::described);
}

#[test]
fn no_name_is_taken_twice() {
    let mut seen = HashSet::new();
    for plugin in plugin::all() {
        assert!(seen.insert((plugin.stage, (plugin.name)())), "{} {}", plugin.stage, (plugin.name)());
    }
}

#[test]
fn every_default_is_written_and_read_back() {
    instances::<dyn Clusterer>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Correspondence>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Deformer>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Format>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn KeyPoints>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Metric>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Proximity>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Generator>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Sampler>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Transfer>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
    instances::<dyn Weights>().iter().for_each(|(name, stage)| contracts::round_trips(name, &**stage));
}

#[test]
fn every_correspondence_keeps_its_contract() {
    let mut checked = 0;
    for (name, mut stage) in instances::<dyn Correspondence>() {
        let files: Vec<PathBuf> = stage.files().into_iter().map(|path| path.clone()).collect();
        if files.is_empty() {
            contracts::correspondence(name, &*stage);
            checked += 1;
        } else {
            // What a file holds is not for the stage to promise; tests/cli.rs runs it on a file that a run kept.
            assert_eq!(name, "from_file");
        }
    }
    assert!(checked >= 3, "identity, nearest and nonrigid_fit at least");
}

#[test]
fn every_transfer_keeps_its_contract() {
    instances::<dyn Transfer>().iter().for_each(|(name, stage)| contracts::transfer(name, &**stage));
}

#[test]
fn every_format_keeps_its_contract() {
    instances::<dyn Format>().iter().for_each(|(name, stage)| contracts::format(name, &**stage));
}

#[test]
fn every_metric_keeps_its_contract() {
    instances::<dyn Metric>().iter().for_each(|(name, stage)| contracts::metric(name, &**stage));
}

#[test]
fn every_proximity_keeps_its_contract() {
    instances::<dyn Proximity>().iter().for_each(|(name, stage)| contracts::proximity(name, &**stage));
}

#[test]
fn every_sample_keeps_its_contract() {
    instances::<dyn Generator>().iter().for_each(|(name, stage)| contracts::generator(name, &**stage));
}

#[test]
fn every_sampler_keeps_its_contract() {
    let (given, others): (Vec<_>, Vec<_>) =
        instances::<dyn Sampler>().into_iter().partition(|(name, _)| *name == "given");
    assert!(given.len() == 1 && others.len() >= 2, "what is given is not for the stage to promise");
    others.iter().for_each(|(name, stage)| contracts::sampler(name, &**stage));
}

#[test]
fn all_weights_keep_their_contract() {
    instances::<dyn Weights>().iter().for_each(|(name, stage)| contracts::weights(name, &**stage));
}

#[test]
fn every_clusterer_keeps_its_contract() {
    instances::<dyn Clusterer>().iter().for_each(|(name, stage)| contracts::clusterer(name, &**stage));
}

#[test]
fn every_deformer_keeps_its_contract() {
    instances::<dyn Deformer>().iter().for_each(|(name, stage)| contracts::deformer(name, &**stage));
}

#[test]
fn every_choice_of_key_points_keeps_its_contract() {
    instances::<dyn KeyPoints>().iter().for_each(|(name, stage)| contracts::key_points(name, &**stage));
}
