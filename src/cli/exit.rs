//! How a command ends: its exit status and its errors.

use std::process::ExitCode;

use overfall::output::OutputError;

/// The exit status that shells report for a command ended by SIGINT.
pub(super) const EXIT_STATUS: u8 = 130;

/// How a command ended; scripts see the exit status.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Exit {
    /// 0: done.
    Done,
    /// 1: the run failed; its summary is written nevertheless.
    Failed,
    /// 2: the scene or the options were refused (clap exits with 2 as well).
    Refused,
    /// 130: ended early by a signal, as shells report SIGINT.
    Interrupted,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::Failed => 1,
            Exit::Refused => 2,
            Exit::Interrupted => EXIT_STATUS,
        })
    }
}

/// Why a command failed, in words for its user.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Failure {
    /// The input is wrong: it must be changed before another attempt.
    Refused(String),
    /// The input is correct, but something else failed (a full disk, a missing permission, an unstable run).
    Failed(String),
}

impl Failure {
    pub(super) fn into_text(self) -> String {
        match self {
            Self::Refused(text) | Self::Failed(text) => text,
        }
    }
}

pub(super) fn cannot_write(error: OutputError) -> Failure {
    Failure::Failed(format!("cannot write {error}"))
}
