//! The program `sealegs`; see the library beside it.

fn main() -> std::process::ExitCode {
    sealegs_cli::run()
}
