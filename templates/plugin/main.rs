use my_stage as _;
fn main() -> std::process::ExitCode {
    mimesh::cli::main()
}
