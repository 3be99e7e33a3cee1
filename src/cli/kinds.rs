//! Files that were given to the wrong command: a scene to `overfall study`, a study or an order to `overfall run`.

use std::path::Path;

use overfall::frontier::is_frontier;
use overfall::input::read_text;
use overfall::scene::{Scene, SceneError};
use overfall::step::Order;
use overfall::study::is_study;

/// What a RON file may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scene,
    Study,
    Order,
}

impl Kind {
    /// What the file is, if it is any.
    fn of(path: &Path) -> Option<Self> {
        let text = read_text(path).ok()?;
        if is_study(&text) || is_frontier(&text) {
            return Some(Self::Study);
        }
        if Order::parse(&text).is_ok() {
            return Some(Self::Order);
        }
        let scene = Scene::parse(&text, &path.display().to_string(), &[]);
        let is_scene = !matches!(scene, Err(SceneError::Syntax { .. }));
        is_scene.then_some(Self::Scene)
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Scene => "this is a scene, which `overfall run` takes",
            Self::Study => "this is a study, which `overfall study` takes",
            Self::Order => "this is an order of stages, which a scene names: `order: \"FILE\"`",
        }
    }
}

/// The refusal of a file by a command that takes files of one kind, and what the file is if it is of another.
pub(super) fn with_kind(refusal: String, path: &Path, taken: Kind) -> String {
    match Kind::of(path).filter(|kind| *kind != taken) {
        Some(kind) => format!("{refusal}\n{}: {}", path.display(), kind.hint()),
        None => refusal,
    }
}
