//! `--set PATH=VALUE`: one field of a scene, replaced.
//!
//! A path may lead into fields that the file leaves to their defaults, so the file's text is no place to replace in.
//! A tree of untyped values would do, but ron's loses the names of variants. So: the scene is written out as RON with
//! all its defaults, the new value takes the place of the old one in that text, and the text is read again.

use std::ops::Range;
use std::str::FromStr;

use ron::error::SpannedError;

use super::explain::{explain, explain_in_file};
use super::ron_text::{deserialize, options, plain_names};
use super::slips::slip;
use super::spans::{Lost, Node, byte_at, scan};
use crate::scene::{Place, Scene, SceneError, unknown_name};

/// A change to one field of a scene.
///
/// The path's steps are field names, positions in a list from 0, and `x`, `y`, `z` of a vector; variants are walked
/// through: `pressure.max_density_error`, `bodies.0.shape.max.x`. The value is RON; a text needs no quotes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Path of the field, steps separated by dots.
    pub path: String,
    /// The new value, in RON.
    pub value: String,
}

impl Override {
    /// Reads `path=value`.
    ///
    /// Fails if there is no `=`, or a step of the path is empty.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let refuse = |message: &str| {
            Err(SceneError::Syntax {
                place: Place::Override(text.to_owned()),
                message: message.to_owned(),
            })
        };
        let Some((path, value)) = text.split_once('=') else {
            let meant = text.split_once(':').or_else(|| text.trim().split_once(' '));
            return match meant.map(|(path, value)| (path.trim(), value.trim())) {
                Some((path, value)) if is_path(path) && !value.is_empty() => refuse(&format!(
                    "expected PATH=VALUE; did you mean `{path}={value}`?"
                )),
                _ => refuse("expected PATH=VALUE, such as `spacing=0.01`"),
            };
        };
        let (path, value) = (path.trim(), value.trim());
        if path.split('.').any(|step| step.trim().is_empty()) {
            return refuse("expected a path such as `pressure.max_density_error` before the `=`");
        }
        if value.is_empty() {
            return refuse("expected a value after the `=`");
        }
        Ok(Self {
            path: path.to_owned(),
            value: value.to_owned(),
        })
    }

    /// The override as an error's place.
    pub(super) fn place(&self) -> Place {
        Place::Override(format!("{}={}", self.path, self.value))
    }

    /// The scene with the field replaced. Only types are checked; see [`Scene::check`].
    pub fn apply(&self, scene: &Scene) -> Result<Scene, SceneError> {
        let refuse = |message: String| SceneError::Syntax {
            place: self.place(),
            message,
        };
        let text = options()
            .to_string(scene)
            .map(|text| plain_names(&text))
            .map_err(|error| refuse(error.to_string()))?;
        let tree =
            scan(&text).ok_or_else(|| refuse("the scene cannot be written out".to_owned()))?;

        let steps: Vec<&str> = self.path.split('.').collect();
        let (node, done, lost) = tree.follow(&steps);
        let splice = |value: &str| {
            let mut changed = text.clone();
            // The line break ends a comment that the value may bring along.
            changed.replace_range(node.span.clone(), &format!("{value}\n"));
            deserialize(&changed)
        };
        let here = steps[..done].join(".");
        match lost {
            None => self
                .replace(splice)
                .map_err(|message| {
                    let mut changed = text.clone();
                    changed.replace_range(node.span.clone(), &format!("{}\n", self.value));
                    let span = node.span.start..node.span.start + self.value.len();
                    match slip::<Scene>(&changed, span.clone()) {
                        // No value may bring in a second field.
                        Some(slip) if slip.is_of_one_value() => {
                            slip.in_override(&self.path, &self.value)
                        }
                        _ => self.deeper_slip(&changed, span).unwrap_or(message),
                    }
                })
                .map_err(refuse),
            Some(Lost::NoField { at, known }) => {
                let of = at.name.or(Some(&here)).filter(|name| !name.is_empty());
                let message = unknown_name("field", steps[done], of, &known);
                // Another variant: `time_step.Fixed=0.001`.
                let variant = format!("{}({})", steps[done], self.value);
                let is_last = done + 1 == steps.len() && at.name.is_some();
                let meant = match self.path_meant(at, &steps, done) {
                    Some(path) => Some(format!("{path}={}", self.value)),
                    None if is_last && splice(&variant).is_ok() => {
                        Some(format!("{here}={variant}"))
                    }
                    None => None,
                };
                Err(refuse(match meant {
                    Some(meant) => {
                        format!("unknown field `{}`; did you mean `{meant}`?", steps[done])
                    }
                    None => message,
                }))
            }
            Some(Lost::NoEntry { length: 0 }) => Err(refuse(format!(
                "`{here}` is empty: there is no entry `{}`",
                steps[done]
            ))),
            Some(Lost::NoEntry { length }) => Err(refuse(format!(
                "`{here}` has no entry `{}`; it has {length}, numbered from 0",
                steps[done]
            ))),
            // An optional struct that the scene leaves out: the path's rest makes one, if its other fields have
            // defaults.
            Some(Lost::NothingInside { at }) if &text[at.span.clone()] == "None" => {
                let (open, close) = (steps[done..].iter().rev())
                    .fold((String::new(), String::new()), |(open, close), step| {
                        (format!("({step}: {open}"), close + ")")
                    });
                self.replace(|value| splice(&format!("{open}{value}{close}")))
                    .map_err(|_| {
                        refuse(format!(
                            "`{here}` is `None`, with no `{}` to set; set all of it: --set '{here}=…'",
                            steps[done]
                        ))
                    })
            }
            Some(Lost::NothingInside { at }) => Err(refuse(format!(
                "`{here}` is the single value `{}`; it has no `{}`",
                &text[at.span.clone()],
                steps[done]
            ))),
        }
    }

    /// The path that was meant by one that leads to no field of the value `at`, which its first `done` steps lead to.
    fn path_meant(&self, at: &Node, steps: &[&str], done: usize) -> Option<String> {
        // Variants are walked through: `time_step.factor`, not `time_step.Cfl.factor`.
        let is_variant = at
            .name
            .is_some_and(|name| name.eq_ignore_ascii_case(steps[done]));
        let without = (is_variant && done + 1 < steps.len())
            .then(|| [&steps[..done], &steps[done + 1..]].concat().join("."));
        self.in_dots().or(without).or_else(|| {
            let meant = deeper(at, &steps[done..])?;
            let shown = [&steps[..done], &[meant.as_str()]].concat();
            Some(shown.join("."))
        })
    }

    /// What is wrong within the value, where the scene's text has it; none if the value is right there.
    fn deeper_slip(&self, changed: &str, span: Range<usize>) -> Option<String> {
        let error = deserialize::<Scene>(changed).err()?;
        let SceneError::Syntax { message, place } = explain_in_file::<Scene>(&error, changed, "")
        else {
            return None;
        };
        // Elsewhere the scene is right.
        let Place::File { line, column, .. } = place else {
            return None;
        };
        if !span.contains(&byte_at(changed, line, column)) {
            return None;
        }
        // A value that is no RON may close brackets of the scene, of which nobody wants to hear.
        let is_ours = scan(&self.value).is_some() || message.contains("did you mean");
        is_ours.then_some(message)
    }

    /// What is wrong with a value that is no RON.
    fn not_ron(&self) -> String {
        let parts = self.value.split([',', ';']).map(str::trim);
        let others: Vec<&str> = (parts.skip(1))
            .filter(|part| part.split_once('=').is_some_and(|(path, _)| is_path(path)))
            .collect();
        match &others[..] {
            [] => "the value is not RON".to_owned(),
            [other, ..] => {
                format!("an override replaces one value; write another for each: `--set {other}`")
            }
        }
    }

    /// The path with dots for the brackets of another language, `bodies[0]`; none if it has no brackets.
    fn in_dots(&self) -> Option<String> {
        let has_brackets = self.path.contains('[');
        has_brackets.then(|| self.path.replace('[', ".").replace(']', ""))
    }

    /// Tries the value as RON, then as a text without its quotes; the message is that of the first.
    fn replace(
        &self,
        splice: impl Fn(&str) -> Result<Scene, SpannedError>,
    ) -> Result<Scene, String> {
        // A value such as `1, support: 3` must not bring in a second field.
        let first = if scan(&self.value).is_some() {
            splice(&self.value).map_err(|error| explain(&error.code))
        } else {
            Err(self.not_ron())
        };
        first.or_else(|message| {
            let quoted = options()
                .to_string(&self.value)
                .map_err(|_| message.clone())?;
            splice(&quoted).map_err(|_| message)
        })
    }
}

/// Whether a text may be the path of an override.
fn is_path(text: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    text.starts_with(|c: char| c.is_alphabetic()) && text.trim().chars().all(is_part)
}

/// The path within a value to the one place deeper in it that some steps lead to from somewhere; none if there are
/// several.
fn deeper(at: &Node, steps: &[&str]) -> Option<String> {
    let mut found: Vec<String> = Vec::new();
    let is_same = |(name, step): (&&str, &&str)| {
        let axes = [("0", "x"), ("1", "y"), ("2", "z")];
        name == step || axes.contains(&(name, step))
    };
    at.leaves("", &mut |path, _| {
        let names: Vec<&str> = path.split('.').collect();
        for start in 1..names.len() {
            let end = start + steps.len();
            let part = names.get(start..end);
            if part.is_some_and(|part| part.iter().zip(steps).all(is_same)) {
                let path = [&names[..start], steps].concat().join(".");
                if !found.contains(&path) {
                    found.push(path);
                }
            }
        }
    });
    match &mut found[..] {
        [only] => Some(std::mem::take(only)),
        _ => None,
    }
}

impl FromStr for Override {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::parse(text)
    }
}
