//! A copy of the scene in the run's folder, so that the run can be repeated and drawn again.

use std::path::Path;

use overfall::input::read_bytes;
use overfall::output::write_atomically;
use overfall::scene::Scene;

use super::claims::Claims;
use super::exit::{Failure, cannot_write};
use super::manifest::create_folder;

/// The folder of the copy, and the scene's file in it.
const FOLDER: &str = "scene";
pub(super) const SCENE: &str = "scene/scene.ron";

/// A scene as text, and the files that it names.
pub(super) struct SceneCopy {
    /// Names relative to the run's folder, and contents; the scene comes last.
    files: Vec<(String, Vec<u8>)>,
}

impl SceneCopy {
    /// Reads the files now. They are written later, since preparing the output folder may move them.
    pub(super) fn of(scene: &Scene) -> Result<Self, Failure> {
        let mut scene = scene.clone();
        let mut files = Vec::new();
        let has_order = scene.order.is_some();
        for path in scene.files_mut() {
            let bytes = read_bytes(Path::new(&*path))
                .map_err(|error| Failure::Refused(format!("cannot read {path}: {error}")))?;
            let extension = Path::new(&*path).extension().unwrap_or_default();
            let name = match extension.to_str() {
                _ if has_order && files.is_empty() => "order.ron".to_owned(),
                Some(extension) if is_mesh(extension) => {
                    format!("mesh_{}.{}", files.len(), extension.to_lowercase())
                }
                _ => format!("reference_{}.csv", files.len()),
            };
            path.clone_from(&name);
            files.push((format!("{FOLDER}/{name}"), bytes));
        }
        let text = (scene.to_ron())
            .map_err(|error| Failure::Failed(format!("cannot write the scene out: {error}")))?;
        files.push((SCENE.to_owned(), text.into_bytes()));
        Ok(Self { files })
    }

    /// The names of the files, relative to the run's folder.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|(name, _)| name.as_str())
    }

    /// Writes the copy into a run's folder.
    pub(super) fn write(&self, root: &Path, claims: &Claims) -> Result<(), Failure> {
        create_folder(&root.join(FOLDER))?;
        for (name, bytes) in &self.files {
            claims
                .claim(name)
                .and_then(|path| {
                    write_atomically(&path, |out| std::io::Write::write_all(out, bytes))
                })
                .map_err(cannot_write)?;
        }
        Ok(())
    }
}

/// Whether files with this extension are meshes.
fn is_mesh(extension: &str) -> bool {
    extension.eq_ignore_ascii_case("obj") || extension.eq_ignore_ascii_case("stl")
}
