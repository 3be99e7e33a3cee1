//! Reads and checks the file of a stability study, and puts the scenes of its points together.

use std::path::{Path, PathBuf};

use super::{Axis, MapVariant, StabilityStudy, template};
use crate::{
    input::{no_file, read_text},
    loading::{Override, place_of, read},
    scene::{Place, Scene, SceneError},
    study::StudyError,
};

/// Most points of a study: a map of 100 by 100 with ten seeds.
const MOST_POINTS: usize = 100_000;

/// A checked stability study.
#[derive(Debug, Clone)]
pub struct StabilityPlan {
    /// The study as in its file.
    pub study: StabilityStudy,
    /// Its variants, each with its axes.
    pub maps: Vec<PlannedMap>,
    /// The scene file.
    pub scene_file: PathBuf,
    overrides: Vec<Override>,
}

/// A variant and its axes.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedMap {
    /// Its name.
    pub name: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Overrides of the study and the variant.
    set: Vec<String>,
}

/// One run of a study: a variant, its values, its seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointOf<'a> {
    /// The variant.
    pub map: &'a PlannedMap,
    /// Value on the horizontal axis.
    pub x: f64,
    /// Value on the vertical axis.
    pub y: f64,
    /// Seed; `None` in studies without seeds.
    pub seed: Option<u32>,
}

impl StabilityPlan {
    /// Reads the study file at `path` and checks it; `overrides` of the scene come before the study's.
    pub fn load(path: &Path, overrides: &[Override]) -> Result<Self, StudyError> {
        let text = read_text(path).map_err(|source| StudyError::Unreadable {
            what: "study",
            file: path.to_owned(),
            source,
        })?;
        let file = path.display().to_string();
        let study: StabilityStudy = read(&text, &file)?;
        let checker = Checker {
            study: &study,
            text: &text,
            file: &file,
        };
        let maps = checker.maps()?;
        checker.check_runs(&maps)?;
        let scene_file = path.parent().unwrap_or(Path::new("")).join(&study.scene);
        if let Some(reason) = no_file(&scene_file) {
            return checker.refuse("scene", reason);
        }
        let plan = Self {
            scene_file,
            overrides: overrides.to_vec(),
            maps,
            study: study.clone(),
        };
        for number in 0..plan.maps.len() {
            checker.check_scenes(&plan, number)?;
        }
        Ok(plan)
    }

    /// Leaves only the variants with these names. Fails with the names that there are if one is unknown.
    pub fn only(&mut self, names: &[String]) -> Result<(), String> {
        let known: Vec<&str> = self.maps.iter().map(|map| map.name.as_str()).collect();
        if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
            return Err(crate::scene::unknown_name("variant", unknown, None, &known));
        }
        self.maps.retain(|map| names.contains(&map.name));
        Ok(())
    }

    /// Seeds, or the one run without.
    pub fn seeds(&self) -> Vec<Option<u32>> {
        match &self.study.seeds {
            Some(seeds) => seeds.values.iter().copied().map(Some).collect(),
            None => vec![None],
        }
    }

    /// The overrides of a point, in the form of `--set`.
    pub fn set(&self, point: PointOf) -> Result<Vec<String>, String> {
        let given = self.overrides.iter();
        let mut set: Vec<String> = given
            .map(|of| format!("{}={}", of.path, of.value))
            .collect();
        set.extend(point.map.set.iter().cloned());
        let mut add = |templates: &[String], value: f64| -> Result<(), String> {
            for template in templates {
                set.push(template::fill(template, value)?);
            }
            Ok(())
        };
        add(&point.map.x.set, point.x)?;
        add(&point.map.y.set, point.y)?;
        if let (Some(seeds), Some(seed)) = (&self.study.seeds, point.seed) {
            add(&seeds.set, seed.into())?;
        }
        Ok(set)
    }

    /// The scene of a point. The error says what is wrong with it.
    pub fn scene(&self, point: PointOf) -> Result<Scene, SceneError> {
        let changes = self.set(point).map_err(|message| SceneError::Syntax {
            place: Place::Override(String::new()),
            message,
        })?;
        let changes: Result<Vec<_>, _> = changes.iter().map(|text| Override::parse(text)).collect();
        Scene::load(&self.scene_file, &changes?)
    }
}

struct Checker<'a> {
    study: &'a StabilityStudy,
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

    /// Path and axis of a variant: its own, or the study's.
    fn axis<'a>(
        &'a self,
        (k, name): (usize, &str),
        own: Option<&'a Axis>,
        common: Option<&'a Axis>,
    ) -> Result<(String, &'a Axis), StudyError> {
        match (own, common) {
            (Some(axis), _) => Ok((format!("variants.{k}.{name}"), axis)),
            (None, Some(axis)) => Ok((name.to_owned(), axis)),
            (None, None) => self.refuse(
                &format!("variants.{k}"),
                format!("there is no `{name}`, neither here nor in the study; one of them has to have it"),
            ),
        }
    }

    fn axes<'a>(
        &'a self,
        k: usize,
        of: &'a MapVariant,
    ) -> Result<[(String, &'a Axis); 2], StudyError> {
        Ok([
            self.axis((k, "x"), of.x.as_ref(), self.study.x.as_ref())?,
            self.axis((k, "y"), of.y.as_ref(), self.study.y.as_ref())?,
        ])
    }

    fn maps(&self) -> Result<Vec<PlannedMap>, StudyError> {
        let study = self.study;
        if let Err(message) = crate::study::names::folder_name(&study.name) {
            return self.refuse("name", message);
        }
        let names = study.variants.iter().map(|variant| variant.name.as_str());
        if let Err((k, message)) = crate::study::names::distinct(names, "variants") {
            let path = k.map_or("variants".to_owned(), |k| format!("variants.{k}.name"));
            return self.refuse(&path, message);
        }
        let mut maps = Vec::new();
        for (k, variant) in study.variants.iter().enumerate() {
            let axes = self.axes(k, variant)?;
            for (which, (path, axis)) in axes.iter().enumerate() {
                self.check_axis(path, axis, which == 1)?;
            }
            let [(_, x), (_, y)] = axes;
            maps.push(PlannedMap {
                name: variant.name.clone(),
                x: x.clone(),
                y: y.clone(),
                set: [&study.set[..], &variant.set].concat(),
            });
        }
        Ok(maps)
    }

    fn check_axis(&self, path: &str, axis: &Axis, may_be_edge: bool) -> Result<(), StudyError> {
        match axis.check(may_be_edge) {
            Ok(()) => Ok(()),
            Err((part, message)) => self.refuse(&format!("{path}.{part}"), message),
        }
    }

    /// Checks seeds, steps, rules and the number of points.
    fn check_runs(&self, maps: &[PlannedMap]) -> Result<(), StudyError> {
        let study = self.study;
        let after = &study.after;
        if after.is_empty() || after[0] == 0 || after.windows(2).any(|pair| pair[0] >= pair[1]) {
            return self.refuse(
                "after",
                "numbers of steps have to ascend from 1 or more, such as [10, 1000]",
            );
        }
        if let Some((name, message)) = study.rules.wrong() {
            return self.refuse(&format!("rules.{name}"), message);
        }
        if let Some(seeds) = &study.seeds {
            let mut values = seeds.values.clone();
            values.sort_unstable();
            values.dedup();
            if values.is_empty() || values.len() < seeds.values.len() {
                return self.refuse(
                    "seeds.values",
                    "seeds have to be different, and one at least",
                );
            }
            for (k, text) in seeds.set.iter().enumerate() {
                if let Err(message) = template::fill(text, 1.0) {
                    return self.refuse(&format!("seeds.set.{k}"), message);
                }
            }
            if !seeds.set.iter().any(|text| template::has_value(text)) {
                let message = "no override has the seed in it, such as `bodies.0.jitter.seed={v}`; all runs of a \
                               point would be the same";
                return self.refuse("seeds.set", message);
            }
        }
        let runs = study.seeds.as_ref().map_or(1, |seeds| seeds.values.len());
        let of_map =
            |map: &PlannedMap| map.x.known_values().len() * map.y.known_values().len() * runs;
        let points: usize = maps.iter().map(of_map).sum();
        if points > MOST_POINTS {
            let message = format!(
                "there are {points} points, more than {MOST_POINTS}; take fewer values or seeds"
            );
            return self.refuse("variants", message);
        }
        Ok(())
    }

    /// Checks the scenes at two opposite corners of a map. What no value can mend is refused; a scene that the value
    /// itself makes wrong is a point of class `Refused`.
    fn check_scenes(&self, plan: &StabilityPlan, number: usize) -> Result<(), StudyError> {
        let map = &plan.maps[number];
        let (xs, ys) = (map.x.known_values(), map.y.known_values());
        let seed = plan.seeds()[0];
        let mut refusals = Vec::new();
        let ends = [(xs.first(), ys.first()), (xs.last(), ys.last())];
        for (x, y) in ends.into_iter().filter_map(|(x, y)| Some((*x?, *y?))) {
            let point = PointOf { map, x, y, seed };
            let Err(error) = plan.scene(point) else {
                continue;
            };
            let place = self.place_in_study(number, &error, point, plan);
            match (&error, place) {
                (SceneError::Syntax { message, .. }, Some(path)) => {
                    return self.refuse(&path, message.clone());
                }
                (SceneError::Invalid { .. }, Some(path)) => {
                    refusals.push((path, error.to_string()))
                }
                _ => return Err(error.into()),
            }
        }
        match refusals.pop() {
            Some((path, message)) if !refusals.is_empty() => self.refuse(
                &path,
                format!("both ends of the axes are refused: {message}"),
            ),
            _ => Ok(()),
        }
    }

    /// The override of the study that an error speaks of.
    fn place_in_study(
        &self,
        number: usize,
        error: &SceneError,
        point: PointOf,
        plan: &StabilityPlan,
    ) -> Option<String> {
        let (SceneError::Syntax {
            place: Place::Override(of),
            ..
        }
        | SceneError::Invalid {
            place: Place::Override(of),
            ..
        }) = error
        else {
            return None;
        };
        let variant = &self.study.variants[number];
        let axes = self.axes(number, variant).ok()?;
        let seeds = self.study.seeds.as_ref();
        let of_variant = format!("variants.{number}.set");
        let lists = [
            ("set".to_owned(), &self.study.set[..]),
            (of_variant, &variant.set),
            (format!("{}.set", axes[0].0), &axes[0].1.set),
            (format!("{}.set", axes[1].0), &axes[1].1.set),
            (
                "seeds.set".to_owned(),
                seeds.map_or(&[], |seeds| &seeds.set[..]),
            ),
        ];
        let paths = lists
            .iter()
            .flat_map(|(path, list)| (0..list.len()).map(move |k| format!("{path}.{k}")));
        let texts = plan.set(point).ok()?;
        let same = |text: &str| {
            let text = Override::parse(text).ok();
            text.is_some_and(|change| format!("{}={}", change.path, change.value) == *of)
        };
        let given = plan.overrides.len();
        let mut found = texts.iter().skip(given).zip(paths).collect::<Vec<_>>();
        found.reverse();
        found
            .into_iter()
            .find(|(text, _)| same(text) || *text == of)
            .map(|(_, path)| path)
    }
}
