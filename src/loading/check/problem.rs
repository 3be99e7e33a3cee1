//! What a check says of a field that is wrong.

/// What is wrong with a field, and what would be right.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::loading) struct Problem {
    /// Path of the field, as `--set` takes it.
    pub(in crate::loading) path: String,
    pub(in crate::loading) message: String,
}

impl Problem {
    pub(in crate::loading) fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            message: message.into(),
        }
    }
}

pub(super) type Checked = Result<(), Problem>;

pub(super) fn ensure(
    right: bool,
    path: impl Into<String>,
    message: impl FnOnce() -> String,
) -> Checked {
    if right {
        Ok(())
    } else {
        Err(Problem::new(path, message()))
    }
}
