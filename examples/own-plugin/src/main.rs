//! `mimesh` with the stages of this package: everything the stock program does, and what `src/lib.rs` adds.

use own_plugin as _;

fn main() -> std::process::ExitCode {
    mimesh::cli::main()
}
