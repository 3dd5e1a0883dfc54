//! Compiles the crate again when what is built of `web/` changes; npm alone builds it.

fn main() {
    println!("cargo::rerun-if-changed=../../web/dist");
}
