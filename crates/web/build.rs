//! Compiles the crate again when the built page changes; the page itself is built by npm alone.

fn main() {
    println!("cargo::rerun-if-changed=../../web/dist");
}
