//! One file per command: arguments → options → library call → report.

pub mod init;

use std::process::ExitCode;

/// Parses the command line and runs it.
pub fn run() -> ExitCode {
    ExitCode::SUCCESS
}
