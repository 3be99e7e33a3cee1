//! Checks a study file and everything it names before anything runs.

use std::path::Path;

use super::memory::lacks_memory;
use super::names;
use super::plan::{Plan, PlannedCase, PlannedVariant};
use super::{Chart, Measure, Reference, Span, Start, Study, StudyError};
use crate::input::{no_file, read_text};
use crate::step::{InstallError, check_order};
use crate::{
    loading::{Override, place_of, read},
    scene::{Place, Scene, SceneError, unknown_name},
};

/// Largest number of blocks: each is kept in memory until the end.
const MOST_BLOCKS: u32 = 10_000;

impl Plan {
    /// Reads the study file at `path`, its scene and its reference figures, and checks all overrides. Errors name file,
    /// line and column, the mistake and the remedy.
    pub fn load(path: &Path) -> Result<Self, StudyError> {
        Self::load_with(path, &[])
    }

    /// As [`load`](Self::load), with `overrides` of the scene, which come before those of the cases and variants.
    pub fn load_with(path: &Path, overrides: &[Override]) -> Result<Self, StudyError> {
        let text = read_file("study", path)?;
        let file = path.display().to_string();
        let mut study: Study = read(&text, &file)?;
        let (cases, reference) = Checker {
            study: &study,
            text: &text,
            file: &file,
            folder: path.parent().unwrap_or(Path::new("")),
            overrides,
        }
        .check()?;
        for column in &mut study.columns {
            if let (Measure::Gauge(measure), Some(case)) = (&mut column.measure, cases.first()) {
                measure.name_its_column(&case.variants[0].scene);
            }
        }
        Ok(Self {
            study,
            cases,
            reference,
        })
    }
}

fn read_file(what: &'static str, path: &Path) -> Result<String, StudyError> {
    read_text(path).map_err(|source| StudyError::Unreadable {
        what,
        file: path.to_owned(),
        source,
    })
}

struct Checker<'a> {
    study: &'a Study,
    text: &'a str,
    file: &'a str,
    folder: &'a Path,
    overrides: &'a [Override],
}

/// The overrides of a list in the file, and the path of that list.
type Set<'a> = (String, &'a [String]);

impl Checker<'_> {
    fn check(&self) -> Result<(Vec<PlannedCase>, Reference), StudyError> {
        self.check_numbers()?;
        self.check_names()?;
        let reference = self.reference()?;
        let cases = self.cases()?;
        self.check_references(&cases, &reference)?;
        self.check_gauges(&cases)?;
        if let Some((path, message)) = lacks_memory(&cases)? {
            return self.refuse(&path, message);
        }
        Ok((cases, reference))
    }

    fn refuse<T>(&self, path: &str, message: impl Into<String>) -> Result<T, StudyError> {
        Err(StudyError::Refused {
            place: place_of(path, self.text, self.file),
            message: message.into(),
        })
    }

    fn check_numbers(&self) -> Result<(), StudyError> {
        let study = self.study;
        if !(1..=MOST_BLOCKS).contains(&study.blocks) {
            let message = format!(
                "`blocks` is {}; it must be at least 1 and at most {MOST_BLOCKS} (5 is usual)",
                study.blocks
            );
            return self.refuse("blocks", message);
        }
        self.check_span("block", study.block, false)?;
        self.check_span("warm_up", study.warm_up, true)?;
        let starts = study.start.iter().map(|start| ("start".to_owned(), start));
        let of_cases = (0..).zip(&study.cases).filter_map(|(k, case)| {
            (case.start.as_ref()).map(|start| (format!("cases.{k}.start"), start))
        });
        for (path, start) in starts.chain(of_cases) {
            self.check_span(&format!("{path}.time"), Span::Time(start.time), false)?;
        }
        for (k, case) in study.cases.iter().enumerate() {
            if let Some(block) = case.block {
                self.check_span(&format!("cases.{k}.block"), block, false)?;
            }
        }
        Ok(())
    }

    fn check_span(&self, path: &str, span: Span, may_be_nothing: bool) -> Result<(), StudyError> {
        let is_right = match span {
            Span::Steps(steps) => steps > 0 || may_be_nothing,
            Span::Time(time) => time.is_finite() && (time > 0.0 || may_be_nothing && time == 0.0),
        };
        match span {
            _ if is_right => Ok(()),
            Span::Steps(_) => self.refuse(path, "no steps; it must be at least 1"),
            Span::Time(time) => self.refuse(path, format!("{time} s; it must be above 0")),
        }
    }

    fn check_names(&self) -> Result<(), StudyError> {
        let study = self.study;
        if let Err(message) = names::folder_name(&study.name) {
            return self.refuse("name", message);
        }
        let variants: Vec<&str> = study.variants.iter().map(|v| v.name.as_str()).collect();
        let columns: Vec<&str> = study.columns.iter().map(|c| c.name.as_str()).collect();
        let cases: Vec<&str> = study.cases.iter().map(|c| c.name.as_str()).collect();
        for (list, names, may_be_empty) in [
            ("variants", &variants, false),
            ("columns", &columns, false),
            ("cases", &cases, true),
        ] {
            match names::distinct(names.iter().copied(), list) {
                Err((Some(k), message)) => {
                    return self.refuse(&format!("{list}.{k}.name"), message);
                }
                Err((None, message)) if !may_be_empty => return self.refuse(list, message),
                Err((None, _)) | Ok(()) => {}
            }
        }
        for (k, column) in study.columns.iter().enumerate() {
            if let Some(message) = study.refusal_of(&column.measure) {
                return self.refuse(&format!("columns.{k}.measure"), message);
            }
        }
        if let Some(name) = &study.baseline {
            self.check_known("baseline", "variant", name, &variants)?;
        }
        match &study.chart {
            Some(Chart::Ratios { columns: shown }) => {
                if shown.is_empty() {
                    return self.refuse("chart.columns", "no column to show; name one");
                }
                for (k, name) in shown.iter().enumerate() {
                    self.check_known(&format!("chart.columns.{k}"), "column", name, &columns)?;
                }
            }
            Some(Chart::Points { x, y }) => {
                self.check_known("chart.x", "column", x, &columns)?;
                if y.is_empty() {
                    return self.refuse("chart.y", "no column to show; name one");
                }
                for (k, name) in y.iter().enumerate() {
                    self.check_known(&format!("chart.y.{k}"), "column", name, &columns)?;
                }
            }
            None => {}
        }
        Ok(())
    }

    fn check_known(
        &self,
        path: &str,
        what: &str,
        name: &str,
        known: &[&str],
    ) -> Result<(), StudyError> {
        if known.contains(&name) {
            return Ok(());
        }
        self.refuse(path, unknown_name(what, name, None, known))
    }

    fn reference(&self) -> Result<Reference, StudyError> {
        let Some(name) = &self.study.reference else {
            return Ok(Reference::default());
        };
        let path = self.folder.join(name);
        if let Some(reason) = no_file(&path) {
            return self.refuse("reference", reason);
        }
        let text = read_file("figures to compare with", &path)?;
        Reference::parse(&text).map_err(|(line, message)| StudyError::Refused {
            place: Place::File {
                file: path.display().to_string(),
                line,
                column: 1,
            },
            message,
        })
    }

    /// Checks that the gauges of all columns exist in the scenes of all variants.
    fn check_gauges(&self, cases: &[PlannedCase]) -> Result<(), StudyError> {
        for (k, column) in self.study.columns.iter().enumerate() {
            let Measure::Gauge(measure) = &column.measure else {
                continue;
            };
            for variant in cases.iter().flat_map(|case| &case.variants) {
                if let Err(message) = measure.check(&variant.scene) {
                    return self.refuse(&format!("columns.{k}.measure"), message);
                }
            }
        }
        Ok(())
    }

    fn check_references(
        &self,
        cases: &[PlannedCase],
        reference: &Reference,
    ) -> Result<(), StudyError> {
        let columns: Vec<&str> = reference.columns.iter().map(String::as_str).collect();
        for (k, column) in self.study.columns.iter().enumerate() {
            if let Some(name) = &column.reference {
                let path = format!("columns.{k}.reference");
                self.check_known(&path, "reference column", name, &columns)?;
            }
        }
        let rows = reference.rows();
        for case in cases {
            for (k, variant) in case.variants.iter().enumerate() {
                if let Some(name) = &variant.reference {
                    let path = format!("variants.{k}.reference");
                    self.check_known(&path, "reference row", name, &rows)?;
                }
            }
        }
        Ok(())
    }

    fn cases(&self) -> Result<Vec<PlannedCase>, StudyError> {
        let study = self.study;
        let common: Set = ("set".into(), &study.set);
        if study.cases.is_empty() {
            let start = study.start.as_ref().map(|start| ("start".into(), start));
            return Ok(vec![PlannedCase {
                name: String::new(),
                start: self.start(start, std::slice::from_ref(&common))?,
                block: study.block,
                variants: self.variants(&[common], None, study.start.is_some())?,
            }]);
        }
        (study.cases.iter().enumerate())
            .map(|(k, case)| {
                let sets = [common.clone(), (format!("cases.{k}.set"), &case.set[..])];
                let own = case
                    .start
                    .as_ref()
                    .map(|start| (format!("cases.{k}.start"), start));
                let start = own.or(study.start.as_ref().map(|start| ("start".into(), start)));
                let has_start = start.is_some();
                Ok(PlannedCase {
                    name: case.name.clone(),
                    start: self.start(start, &sets)?,
                    block: case.block.unwrap_or(study.block),
                    variants: self.variants(&sets, case.reference.as_deref(), has_start)?,
                })
            })
            .collect()
    }

    fn start(
        &self,
        start: Option<(String, &Start)>,
        sets: &[Set],
    ) -> Result<Option<(Scene, f32)>, StudyError> {
        let Some((path, start)) = start else {
            return Ok(None);
        };
        let mut sets = sets.to_vec();
        sets.push((format!("{path}.set"), &start.set));
        Ok(Some((self.scene(&sets, &path)?, start.time)))
    }

    fn variants(
        &self,
        sets: &[Set],
        case_reference: Option<&str>,
        has_start: bool,
    ) -> Result<Vec<PlannedVariant>, StudyError> {
        let base = self.scene(sets, "scene")?;
        (self.study.variants.iter().enumerate())
            .map(|(k, variant)| {
                let path = format!("variants.{k}");
                let mut sets = sets.to_vec();
                sets.push((format!("{path}.set"), &variant.set));
                let scene = self.scene(&sets, &path)?;
                let particles = |scene: &Scene| {
                    (scene.bodies.clone(), scene.spacing, scene.dimension)
                };
                if has_start && particles(&scene) != particles(&base) {
                    return self.refuse(
                        &format!("{path}.set"),
                        "it changes the particles, but starts from a state that was simulated without this change; \
                         make it a case, or leave out `start`",
                    );
                }
                let reference = variant.reference.as_ref().map(|name| match case_reference {
                    Some(case) => format!("{case}, {name}"),
                    None => name.clone(),
                });
                Ok(PlannedVariant {
                    name: variant.name.clone(),
                    scene,
                    rows: variant.rows,
                    reference,
                    series: variant.series.clone(),
                })
            })
            .collect()
    }

    /// The scene with the overrides of some lists. An error that no override causes is reported at the field `path`.
    fn scene(&self, sets: &[Set], path: &str) -> Result<Scene, StudyError> {
        let mut overrides = self.overrides.to_vec();
        let mut places = Vec::new();
        for (list, texts) in sets {
            for (k, text) in texts.iter().enumerate() {
                let place = format!("{list}.{k}");
                let change = Override::parse(text)
                    .or_else(|error| self.relocate(error, |_| Some(place.clone())))?;
                places.push((format!("{}={}", change.path, change.value), place));
                overrides.push(change);
            }
        }
        let scene_file = self.folder.join(&self.study.scene);
        if let Some(reason) = no_file(&scene_file) {
            return self.refuse("scene", reason);
        }
        let scene = Scene::load(&scene_file, &overrides).or_else(|error| {
            self.relocate(error, |change| {
                let found = places.iter().rev().find(|(text, _)| text == change);
                found.map(|(_, place)| place.clone())
            })
        })?;
        check_order(&scene).or_else(|error: InstallError| self.refuse(path, error.to_string()))?;
        Ok(scene)
    }

    /// An error of the scene; if an override caused it, at the place of that override in the study.
    fn relocate<T>(
        &self,
        error: SceneError,
        place: impl Fn(&str) -> Option<String>,
    ) -> Result<T, StudyError> {
        if let SceneError::Syntax {
            place: Place::Override(change),
            message,
        }
        | SceneError::Invalid {
            place: Place::Override(change),
            message,
            ..
        } = &error
            && let Some(path) = place(change)
        {
            return self.refuse(&path, message.clone());
        }
        Err(error.into())
    }
}
