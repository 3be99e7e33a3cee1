//! Reads and checks the file of a frontier study, and puts the scenes of its points together.

use std::path::{Path, PathBuf};

use super::{FrontierStudy, GaugeColumn, Truth};
use crate::{
    input::{no_file, read_text},
    loading::{Override, place_of, read},
    scene::{Place, Scene, SceneError, unknown_name},
    study::{
        StudyError, names,
        stability::{Axis, Values, template},
    },
    validate::{CASES, Case},
};

/// Most points of a study.
const MOST_POINTS: usize = 10_000;

/// A checked frontier study.
#[derive(Debug, Clone)]
pub struct FrontierPlan {
    /// The study as in its file.
    pub study: FrontierStudy,
    /// What is run and what it is compared with.
    pub subject: Subject,
    /// All points, variant by variant.
    pub points: Vec<PlannedPoint>,
    overrides: Vec<Override>,
}

/// What is run.
#[derive(Debug, Clone)]
pub enum Subject {
    /// A case of `overfall validate`.
    Case(&'static Case),
    /// A scene with a fine run.
    Scene {
        /// The scene file.
        file: PathBuf,
        /// Overrides that make it fine.
        fine: Vec<String>,
        /// Curves that are compared.
        gauges: Vec<GaugeColumn>,
    },
}

/// Settings to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedPoint {
    /// The variant.
    pub variant: String,
    /// Its swept values in words, such as `tolerance 0.001, N 20`; empty without any.
    pub settings: String,
    /// Its overrides.
    pub set: Vec<String>,
    /// Place of the variant's overrides in the file.
    variant_number: usize,
}

impl Subject {
    /// The scene file, as commands name it.
    pub fn file(&self) -> PathBuf {
        match self {
            Self::Case(case) => PathBuf::from(format!("assets/cases/{}/scene.ron", case.name)),
            Self::Scene { file, .. } => file.clone(),
        }
    }

    /// The scene with overrides.
    pub fn scene(&self, changes: &[Override]) -> Result<Scene, SceneError> {
        match self {
            Self::Case(case) => {
                Scene::parse(case.texts.0, &self.file().display().to_string(), changes)
            }
            Self::Scene { file, .. } => Scene::load(file, changes),
        }
    }
}

impl FrontierPlan {
    /// Reads the study file at `path` and checks it; `overrides` of the scene come before the study's.
    pub fn load(path: &Path, overrides: &[Override]) -> Result<Self, StudyError> {
        let text = read_text(path).map_err(|source| StudyError::Unreadable {
            what: "study",
            file: path.to_owned(),
            source,
        })?;
        let file = path.display().to_string();
        let study: FrontierStudy = read(&text, &file)?;
        let checker = Checker {
            study: &study,
            text: &text,
            file: &file,
        };
        let subject = checker.subject(path)?;
        let points = checker.points()?;
        let plan = Self {
            subject,
            points,
            overrides: overrides.to_vec(),
            study: study.clone(),
        };
        checker.check_scenes(&plan)?;
        Ok(plan)
    }

    /// Leaves only the variants with these names. Fails with the names that there are if one is unknown.
    pub fn only(&mut self, wanted: &[String]) -> Result<(), String> {
        let known: Vec<&str> = self
            .study
            .variants
            .iter()
            .map(|of| of.name.as_str())
            .collect();
        if let Some(unknown) = wanted.iter().find(|name| !known.contains(&name.as_str())) {
            return Err(unknown_name("variant", unknown, None, &known));
        }
        self.points.retain(|point| wanted.contains(&point.variant));
        Ok(())
    }

    /// The scene with overrides, after those of the command line.
    pub fn scene(&self, set: &[String]) -> Result<Scene, SceneError> {
        let mut changes = self.overrides.clone();
        for text in set {
            changes.push(Override::parse(text)?);
        }
        self.subject.scene(&changes)
    }

    /// All overrides of a point, those of the command line included, in the form of `--set`.
    pub fn set(&self, set: &[String]) -> Vec<String> {
        let given = self.overrides.iter();
        let given = given.map(|of| format!("{}={}", of.path, of.value));
        given.chain(set.iter().cloned()).collect()
    }
}

struct Checker<'a> {
    study: &'a FrontierStudy,
    text: &'a str,
    file: &'a str,
}

impl Checker<'_> {
    fn refuse<T>(&self, path: &str, message: impl Into<String>) -> Result<T, StudyError> {
        Err(StudyError::Refused {
            place: place_of(path, self.text, self.file),
            message: message.into(),
        })
    }

    fn subject(&self, path: &Path) -> Result<Subject, StudyError> {
        if let Err(message) = names::folder_name(&self.study.name) {
            return self.refuse("name", message);
        }
        match &self.study.truth {
            Truth::Case { name, figures } => {
                if figures.is_empty() {
                    return self
                        .refuse("truth.figures", "no figure to show the error of; name one");
                }
                let case = CASES.into_iter().find(|case| case.name == name);
                case.map(Subject::Case).ok_or_else(|| StudyError::Refused {
                    place: place_of("truth.name", self.text, self.file),
                    message: unknown_name("case", name, None, &CASES.map(|case| case.name)),
                })
            }
            Truth::Fine { scene, set, gauges } => {
                if gauges.is_empty() {
                    return self.refuse("truth.gauges", "no gauge to compare; name one");
                }
                let file = path.parent().unwrap_or(Path::new("")).join(scene);
                if let Some(reason) = no_file(&file) {
                    return self.refuse("truth.scene", reason);
                }
                Ok(Subject::Scene {
                    file,
                    fine: set.clone(),
                    gauges: gauges.clone(),
                })
            }
        }
    }

    fn points(&self) -> Result<Vec<PlannedPoint>, StudyError> {
        let study = self.study;
        let all = study.variants.iter().map(|variant| variant.name.as_str());
        if let Err((k, message)) = names::distinct(all, "variants") {
            let path = k.map_or("variants".to_owned(), |k| format!("variants.{k}.name"));
            return self.refuse(&path, message);
        }
        if !(1..=100).contains(&study.repeats) {
            return self.refuse(
                "repeats",
                format!("`repeats` is {}; it must be from 1 to 100", study.repeats),
            );
        }
        if !(study.seconds > 0.0 && study.seconds.is_finite()) {
            return self.refuse(
                "seconds",
                format!("`seconds` is {}; it must be above 0", study.seconds),
            );
        }
        let mut points = Vec::new();
        for (k, variant) in study.variants.iter().enumerate() {
            let common = study
                .grid
                .iter()
                .enumerate()
                .map(|(n, axis)| (format!("grid.{n}"), axis));
            let own = variant.grid.iter().enumerate();
            let own = own.map(|(n, axis)| (format!("variants.{k}.grid.{n}"), axis));
            let axes: Vec<(String, &Axis)> = own.chain(common).collect();
            for (path, axis) in &axes {
                if let Err((part, message)) = axis.check(false) {
                    return self.refuse(&format!("{path}.{part}"), message);
                }
            }
            let first = PlannedPoint {
                variant: variant.name.clone(),
                settings: String::new(),
                set: [&study.set[..], &variant.set].concat(),
                variant_number: k,
            };
            points.extend(product(first, &axes));
            if points.len() > MOST_POINTS {
                let message =
                    format!("there are more than {MOST_POINTS} points; sweep fewer values");
                return self.refuse("variants", message);
            }
        }
        Ok(points)
    }

    /// Checks the scene of every point, and that the gauges exist.
    fn check_scenes(&self, plan: &FrontierPlan) -> Result<(), StudyError> {
        if let Subject::Scene { fine, gauges, .. } = &plan.subject {
            let scene = plan.scene(fine);
            let scene = scene.or_else(|error| self.relocate(error, "truth.set"))?;
            for (k, of) in gauges.iter().enumerate() {
                let path = format!("truth.gauges.{k}");
                let known: Vec<&str> = scene
                    .gauges
                    .iter()
                    .map(|gauge| gauge.name.as_str())
                    .collect();
                let Some(gauge) = scene.gauges.iter().find(|gauge| gauge.name == of.gauge) else {
                    return self.refuse(&path, unknown_name("gauge", &of.gauge, None, &known));
                };
                let columns = gauge.columns();
                let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
                if let Some(column) = of
                    .column
                    .as_deref()
                    .filter(|column| !columns.contains(column))
                {
                    let message = unknown_name("column", column, Some(&of.gauge), &columns);
                    return self.refuse(&path, message);
                }
            }
        }
        let mut last = None;
        for point in &plan.points {
            // What a value makes wrong is a point that failed; what all share is a mistake of the file.
            if last == Some(point.variant_number) {
                continue;
            }
            last = Some(point.variant_number);
            if let Err(error) = plan.scene(&point.set) {
                return self.relocate(error, &format!("variants.{}", point.variant_number));
            }
        }
        Ok(())
    }

    /// An error of the scene, at a place of the study if an override caused it.
    fn relocate<T>(&self, error: SceneError, path: &str) -> Result<T, StudyError> {
        match &error {
            SceneError::Syntax {
                place: Place::Override(change),
                message,
            }
            | SceneError::Invalid {
                place: Place::Override(change),
                message,
                ..
            } => self.refuse(path, format!("`{change}`: {message}")),
            _ => Err(error.into()),
        }
    }
}

/// A point with all values of some axes.
fn product(first: PlannedPoint, axes: &[(String, &Axis)]) -> Vec<PlannedPoint> {
    axes.iter().fold(vec![first], |points, (_, axis)| {
        let with = |point: &PlannedPoint, value: f64| {
            let mut point = point.clone();
            let unit = if axis.unit.is_empty() {
                String::new()
            } else {
                format!(" {}", axis.unit)
            };
            let comma = if point.settings.is_empty() { "" } else { ", " };
            point
                .settings
                .push_str(&format!("{comma}{} {value}{unit}", axis.name));
            // The check of the axis has filled in every value.
            let filled = axis
                .set
                .iter()
                .filter_map(|text| template::fill(text, value).ok());
            point.set.extend(filled);
            point
        };
        let values = match axis.values {
            Values::Edge { .. } => Vec::new(),
            _ => axis.known_values(),
        };
        points
            .iter()
            .flat_map(|point| {
                values
                    .iter()
                    .map(|&value| with(point, value))
                    .collect::<Vec<_>>()
            })
            .collect()
    })
}
