//! One file per command: arguments → options → library call → report.

<<<<<<< HEAD
pub mod predict;
=======
pub mod regress;
>>>>>>> statistics

use std::process::ExitCode;

/// Parses the command line and runs it.
pub fn run() -> ExitCode {
    ExitCode::SUCCESS
}
