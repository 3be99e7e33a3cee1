//! The scene as it ran, kept in the run's folder: the run can be drawn again, and repeated.

use std::fs;
use std::path::Path;

use overfall::scene::Scene;
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;

use super::Failure;
use super::folder::RunFolder;

/// A scene as text, and the text of its order file.
pub(super) struct SceneCopy {
    scene: String,
    order: Option<Vec<u8>>,
}

impl SceneCopy {
    /// Takes the copy. It is written later: the order file may lie in the folder that is made ready in between.
    pub(super) fn of(scene: &Scene) -> Result<Self, Failure> {
        let mut scene = scene.clone();
        let order = match &mut scene.order {
            None => None,
            Some(path) => {
                let text = fs::read(&*path).map_err(|error| {
                    Failure::Refused(format!("cannot read the order {path}: {error}"))
                })?;
                ORDER.clone_into(path);
                Some(text)
            }
        };
        // The spelling that scene files use: no `Some(…)`, one bracket around a variant's fields.
        let scene = ron::Options::default()
            .with_default_extension(Extensions::IMPLICIT_SOME)
            .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES)
            .to_string_pretty(&scene, PrettyConfig::new().new_line("\n"))
            .map_err(|error| Failure::Failed(format!("cannot write the scene out: {error}")))?;
        Ok(Self { scene, order })
    }

    /// Writes the copy into the folder.
    pub(super) fn write(&self, folder: &RunFolder) -> Result<(), Failure> {
        let write = |path: &Path, bytes: &[u8]| {
            fs::write(path, bytes).map_err(|error| {
                Failure::Failed(format!("cannot write {}: {error}", path.display()))
            })
        };
        if let Some(order) = &self.order {
            write(&folder.order(), order)?;
        }
        write(&folder.scene(), format!("{}\n", self.scene).as_bytes())
    }
}

/// The order file's name in the folder.
pub(super) const ORDER: &str = "order.ron";
