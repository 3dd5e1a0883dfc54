//! The `mimesh` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    mimesh::cli::main()
}
