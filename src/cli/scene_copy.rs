//! The scene as it ran, kept in the run's folder: the run can be drawn again, and repeated.

use std::fs;
use std::path::Path;

use overfall::scene::Scene;
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;

use super::Failure;
use super::folder::RunFolder;

/// A scene as text, and the files that it names.
pub(super) struct SceneCopy {
    scene: String,
    /// Names in the folder, and contents.
    files: Vec<(String, Vec<u8>)>,
}

impl SceneCopy {
    /// Takes the copy. It is written later: the files may lie in the folder that is made ready in between.
    pub(super) fn of(scene: &Scene) -> Result<Self, Failure> {
        let mut scene = scene.clone();
        let mut files = Vec::new();
        for path in scene.files_mut() {
            let bytes = fs::read(&*path)
                .map_err(|error| Failure::Refused(format!("cannot read {path}: {error}")))?;
            let extension = Path::new(&*path).extension().unwrap_or_default();
            let name = match extension.to_str() {
                Some(extension) if is_mesh(extension) => {
                    format!("{MESH}{}.{}", files.len(), extension.to_lowercase())
                }
                _ => ORDER.to_owned(),
            };
            path.clone_from(&name);
            files.push((name, bytes));
        }
        // The spelling that scene files use: no `Some(…)`, one bracket around a variant's fields.
        let scene = ron::Options::default()
            .with_default_extension(Extensions::IMPLICIT_SOME)
            .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES)
            .to_string_pretty(&scene, PrettyConfig::new().new_line("\n"))
            .map_err(|error| Failure::Failed(format!("cannot write the scene out: {error}")))?;
        Ok(Self { scene, files })
    }

    /// Writes the copy into the folder.
    pub(super) fn write(&self, folder: &RunFolder) -> Result<(), Failure> {
        let write = |path: &Path, bytes: &[u8]| {
            fs::write(path, bytes).map_err(|error| {
                Failure::Failed(format!("cannot write {}: {error}", path.display()))
            })
        };
        for (name, bytes) in &self.files {
            write(&folder.root().join(name), bytes)?;
        }
        write(&folder.scene(), format!("{}\n", self.scene).as_bytes())
    }
}

/// The order file's name in the folder.
pub(super) const ORDER: &str = "order.ron";

/// How the files of meshes are called in the folder, before a number.
const MESH: &str = "mesh_";

/// Whether files that end so are meshes.
fn is_mesh(extension: &str) -> bool {
    extension.eq_ignore_ascii_case("obj") || extension.eq_ignore_ascii_case("stl")
}

/// Whether a file in the folder is a copy of a scene's mesh, by its name.
pub(super) fn is_copied_mesh(name: &str) -> bool {
    let number = name
        .strip_prefix(MESH)
        .and_then(|rest| rest.rsplit_once('.'));
    number.is_some_and(|(number, extension)| {
        !number.is_empty()
            && number.bytes().all(|digit| digit.is_ascii_digit())
            && is_mesh(extension)
    })
}
