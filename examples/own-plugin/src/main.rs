//! `mimesh` with one more transfer: everything the stock program does, and `transfer: { type: exaggerate }`.
//!
//! A package of your own needs two things: a stage and a `main` of one line. The stage is a struct of settings
//! with the stage's trait; `register!` makes it known, and from then on `list`, `show`, `schema`, `check` and `run`
//! know it and its doc comments:
//!
//! ```sh
//! cargo run --release -p own-plugin -- list
//! cargo run --release -p own-plugin -- show transfer exaggerate
//! cargo run --release -p own-plugin -- run pipelines/gallop.yaml --set 'transfer={type: exaggerate, strength: 1.5}'
//! ```
//!
//! Outside of this repository, depend on `mimesh` and `mimesh-core` and on `schemars`, `serde` and `typetag`; to
//! leave out the stages that mimesh brings, turn off its default features. A stage in a library crate of its own is
//! linked only if the binary names it: `use my_stages as _;`.

mod exaggerate;

use std::process::ExitCode;

fn main() -> ExitCode {
    mimesh::cli::main()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use mimesh::{
        core::plugin,
        pipeline::{Document, parse::parse},
    };

    const PIPELINE: &str = "
source: { sample: { type: quadruped } }
target: { sample: { type: quadruped, proportions: giraffe } }
correspondence: { type: nonrigid_fit }
transfer: { type: exaggerate, strength: 1.5, of: { type: copy_displacement } }
output: out/{pose}.obj
";

    #[test]
    fn the_stage_is_listed_beside_the_built_in_ones() {
        let transfers: Vec<_> =
            plugin::all().into_iter().filter(|p| p.stage == "transfer").map(|p| (p.name)()).collect();
        assert!(transfers.contains(&"exaggerate") && transfers.contains(&"gradient"), "{transfers:?}");
    }

    #[test]
    fn a_pipeline_with_it_is_understood_and_its_settings_are_checked() {
        let mistakes = |text: &str| parse(&Document::parse(Path::new("own.yaml"), text).unwrap()).1;
        assert!(mistakes(PIPELINE).is_empty(), "{:?}", mistakes(PIPELINE));
        assert_eq!(mistakes(&PIPELINE.replace("strength", "strenght")).len(), 1);
        assert_eq!(mistakes(&PIPELINE.replace("exaggerate", "exagerate")).len(), 1);
    }
}
