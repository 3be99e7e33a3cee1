//! Kinds of study files.

use std::path::Path;

use super::StudyError;
use crate::{
    input::read_text,
    loading::{place_of, written_at},
    scene::unknown_name,
};

/// Kind of a study file, by its field `kind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StudyKind {
    /// Variants side by side; no `kind`.
    Table,
    /// A map of where a scene runs well: `kind: Stability`.
    Stability,
    /// Speed against error: `kind: Frontier`.
    Frontier,
}

/// Kinds that are written, by name.
const WRITTEN: [(&str, StudyKind); 2] = [
    ("Stability", StudyKind::Stability),
    ("Frontier", StudyKind::Frontier),
];

impl StudyKind {
    /// The kind of the study file at `path`. Fails if the file cannot be read, or names a kind that there is not.
    pub fn of(path: &Path) -> Result<Self, StudyError> {
        let text = read_text(path).map_err(|source| StudyError::Unreadable {
            what: "study",
            file: path.to_owned(),
            source,
        })?;
        let Some(written) = written_at("kind", &text) else {
            return Ok(Self::Table);
        };
        let known = WRITTEN.iter().find(|(name, _)| *name == written.trim());
        known
            .map(|(_, kind)| *kind)
            .ok_or_else(|| StudyError::Refused {
                place: place_of("kind", &text, &path.display().to_string()),
                message: unknown_name("kind", written.trim(), None, &WRITTEN.map(|(name, _)| name)),
            })
    }
}
