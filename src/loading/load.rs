//! From text to a checked scene: the file first, then the overrides, then the checks.

use std::path::{Path, PathBuf};

use ron::ser::PrettyConfig;

use super::check::{self, Problem, Size};
use super::explain::{place_of, read};
use super::include::Source;
use super::overrides::Override;
use super::ron_text::{options, plain_names};
use super::written;
use crate::input::{no_file, read_text};
use crate::scene::{BodyForce, BoundaryShape, Place, Scene, SceneError, VelocityField};

impl Scene {
    /// Reads the scene file at `path`, applies `overrides` in their order and checks the result.
    ///
    /// Errors name the file, the line and the column, or the override, that cannot be.
    pub fn load(path: &Path, overrides: &[Override]) -> Result<Self, SceneError> {
        let text = read_text(path).map_err(|source| SceneError::Unreadable {
            file: path.to_owned(),
            source,
        })?;
        let file_name = path.display().to_string();
        let source = Source::new(&text, &file_name)?;
        let scene = Self::parse_whole(source.text(), &file_name, overrides);
        let scene = scene.map_err(|error| source.placed(error))?;
        let missing = scene.order.as_deref().map(Path::new).and_then(no_file);
        match missing {
            Some(reason) => {
                let problem = Problem::new("order", reason);
                Err(source.placed(locate(problem, source.text(), &file_name, overrides)))
            }
            None => Ok(scene),
        }
    }

    /// The files of the fragments (`include`) that a scene file is put together from; none if it cannot be read.
    pub fn fragments(path: &Path) -> Vec<PathBuf> {
        let Ok(text) = read_text(path) else {
            return Vec::new();
        };
        let source = Source::new(&text, &path.display().to_string());
        source.map_or_else(
            |_| Vec::new(),
            |source| source.fragments().map(Path::to_owned).collect(),
        )
    }

    /// As [`load`](Self::load), from a text. `file_name` stands in errors; `order`, the meshes' files and fragments
    /// are taken relative to its folder.
    pub fn parse(text: &str, file_name: &str, overrides: &[Override]) -> Result<Self, SceneError> {
        let source = Source::new(text, file_name)?;
        let scene = Self::parse_whole(source.text(), file_name, overrides);
        scene.map_err(|error| source.placed(error))
    }

    /// As [`parse`](Self::parse), from a text without fragments.
    fn parse_whole(
        text: &str,
        file_name: &str,
        overrides: &[Override],
    ) -> Result<Self, SceneError> {
        let mut scene: Self = read(text, file_name)?;
        let placed = |problem| locate(problem, text, file_name, overrides);
        written::carried(text, "").map_err(placed)?;
        for change in overrides {
            scene = change.apply(&scene)?;
            written::carried(&change.value, &change.path).map_err(placed)?;
        }
        if let Some(folder) = Path::new(file_name).parent() {
            for file in scene.files_mut() {
                *file = folder.join(&*file).display().to_string();
            }
        }
        check::check(&scene).map_err(placed)?;
        Ok(scene)
    }

    /// The scene as the text of a scene file, defaults included, in the spelling that files use: no `Some(…)`, one
    /// bracket around a variant's fields. Fails if ron does.
    pub fn to_ron(&self) -> Result<String, SceneError> {
        let pretty = PrettyConfig::new().new_line("\n");
        let written = options().to_string_pretty(self, pretty);
        let text = written.map_err(|error| SceneError::Syntax {
            place: Place::Field("scene".to_owned()),
            message: error.to_string(),
        })?;
        Ok(plain_names(&text) + "\n")
    }

    /// Paths of the files that belong to the scene: the order's, if it names one, then those of the walls, meshes and
    /// tables of motion, then those that gauges are compared with, then tables of accelerations, then the shapes
    /// and the velocities at the start of bodies.
    pub fn files_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let walls = self.boundaries.iter_mut();
        let walls = walls.flat_map(BoundaryShape::files_mut);
        let references = self.gauges.iter_mut().filter_map(|gauge| {
            let reference = gauge.reference.as_mut()?;
            Some(&mut reference.file)
        });
        let tables = self.body_forces.iter_mut().filter_map(|force| match force {
            BodyForce::Table(table) => Some(&mut table.file),
            BodyForce::Central(_) | BodyForce::Wave(_) => None,
        });
        let bodies = self.bodies.iter_mut().flat_map(|body| {
            let field = match &mut body.velocity_field {
                Some(VelocityField::Table { file }) => Some(file),
                _ => None,
            };
            body.shape.file_mut().into_iter().chain(field)
        });
        let files = self.order.iter_mut().chain(walls).chain(references);
        files.chain(tables).chain(bodies)
    }

    /// Checks a scene that was built in code, as [`load`](Self::load) checks a file.
    pub fn check(&self) -> Result<(), SceneError> {
        self.checked_size().map(|_| ())
    }

    /// As [`check`](Self::check), and says what room the scene needs.
    pub(crate) fn checked_size(&self) -> Result<Size, SceneError> {
        check::check(self).map_err(|problem| SceneError::Invalid {
            place: Place::Field(problem.path.clone()),
            field: problem.path,
            message: problem.message,
        })
    }
}

/// Gives a problem its place: the last override that touches the field, else the field in the file, else (where the
/// field has its default) the innermost value around it that the file does write.
fn locate(problem: Problem, text: &str, file_name: &str, overrides: &[Override]) -> SceneError {
    let touches = |change: &&Override| {
        let (a, b) = (change.path.as_str(), problem.path.as_str());
        let within = |a: &str, b: &str| {
            b.strip_prefix(a)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        within(a, b) || within(b, a)
    };
    let place = match overrides.iter().rev().find(touches) {
        Some(change) => change.place(),
        None => place_of(&problem.path, text, file_name),
    };
    SceneError::Invalid {
        place,
        field: problem.path,
        message: problem.message,
    }
}
