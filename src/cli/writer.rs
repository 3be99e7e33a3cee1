//! A program that is going to write into a folder.

use std::path::{Path, PathBuf};

use super::exit::Failure;
use super::manifest::Listing;

/// A program that is going to write into a folder.
pub(super) struct Writer<'a> {
    /// `run`, `study` or `validation`.
    pub(super) kind: &'static str,
    /// Name of the scene or the study.
    pub(super) name: &'a str,
    /// Whether an older run of the same kind and name is replaced instead of being moved aside.
    pub(super) force: bool,
    /// Files that will be read: none of them may be moved or removed.
    pub(super) inputs: Vec<PathBuf>,
}

impl Writer<'_> {
    /// The manifest's second line.
    pub(super) fn line(&self) -> String {
        format!("{} {:?}", self.kind, self.name)
    }

    /// Refuses to move or remove files of `root` that will be read, such as a scene that an older run kept.
    pub(super) fn refuse_inputs(&self, root: &Path, older: &Listing) -> Result<(), Failure> {
        let same = |a: &Path, b: &Path| match (a.canonicalize(), b.canonicalize()) {
            (Ok(a), Ok(b)) => a == b,
            _ => false,
        };
        for input in &self.inputs {
            let ours = (older.files.iter())
                // Most names already differ in their last part; only the others need access to the disk.
                .filter(|name| {
                    Path::new(name).file_name() == input.file_name() || input.is_symlink()
                })
                .any(|name| same(&root.join(name), input));
            if ours {
                return Err(Failure::Refused(format!(
                    "{}: it is an input, and belongs to an older {} in the folder {}, which would be moved; choose \
                     another --out",
                    input.display(),
                    older.writer,
                    root.display()
                )));
            }
        }
        Ok(())
    }
}
