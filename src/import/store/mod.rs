//! The store of a campaign: every imported profile as a tidy Parquet file, beside it `quarantine.csv` with everything that was set aside.

mod entry;
mod journal;
mod parquet;
mod set_aside;

pub(super) use entry::DEFAULT_STORE;
pub(super) use journal::{Change, commit, recover};
pub(super) use parquet::{Stored, StoredPoint, read, write};
pub(super) use set_aside::{SetAside, harmless, read as read_set_aside, write as write_set_aside};

/// Name of the table of what was set aside.
pub(super) const QUARANTINE: &str = "quarantine.csv";
