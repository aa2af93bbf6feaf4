//! The `hemline` program.

fn main() -> std::process::ExitCode {
    hemline::cli::run()
}
