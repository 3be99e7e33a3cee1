//! The order of the stages as data: a RON file, checked before anything runs.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::stage::{Datum, Stage};
use crate::scene::{Place, Scene, SceneError, TimeStep, read};

/// An order file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Order {
    /// The stages, one after the other.
    pub stages: Vec<OrderItem>,
    /// Whether a stage may use what was current in an earlier step: an experiment, not an error.
    #[serde(default)]
    pub allow_stale: bool,
}

/// A line of an order file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum OrderItem {
    /// A stage by its name.
    Run(String),
    /// Stages that run in the first and then in every so-manieth step.
    Every(u32, Vec<OrderItem>),
    /// Stages that run so many times in a row.
    Repeat(u32, Vec<OrderItem>),
}

/// Why an order is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OrderError {
    /// The file is no order.
    #[error("{line}:{column}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        message: String,
    },
    /// No stage has this name.
    #[error("no stage is called `{name}`{}; the stages are {}", suggestion(.name), names())]
    UnknownStage {
        /// The name.
        name: String,
    },
    /// A count of zero.
    #[error("`{item}` with a count of 0 never runs; the least is 1")]
    ZeroCount {
        /// `Every` or `Repeat`.
        item: &'static str,
    },
    /// A stage lacks what another would make.
    #[error(
        "stage `{stage}` needs {datum}, which {}; stage `{maker}` makes it and must come before{}",
        if *.stale { "is left over from an earlier step there" } else { "nothing has made" },
        if *.stale { " (or say `allow_stale: true`)" } else { "" }
    )]
    Lacks {
        /// The stage.
        stage: &'static str,
        /// What it lacks.
        datum: Datum,
        /// The stage that makes it.
        maker: &'static str,
        /// Whether it exists but is out of date.
        stale: bool,
    },
    /// A stage uses what is left over, and steps may be taken back.
    #[error(
        "stage `{stage}` uses {datum} left over from an earlier step, which `time_step: Adaptive` may have taken back; \
         use `Cfl` or `Fixed`"
    )]
    CannotGoBack {
        /// The stage.
        stage: &'static str,
        /// What is left over.
        datum: Datum,
    },
    /// No stage moves the particles.
    #[error("the order never runs `integrate`: time would stand still")]
    NeverIntegrates,
}

fn suggestion(name: &str) -> String {
    Stage::ALL
        .iter()
        .map(|stage| (strsim::damerau_levenshtein(name, stage.name), stage.name))
        .min()
        .filter(|(distance, _)| *distance <= 3)
        .map_or_else(String::new, |(_, near)| format!("; did you mean `{near}`?"))
}

fn names() -> String {
    Stage::ALL
        .iter()
        .map(|stage| stage.name)
        .collect::<Vec<_>>()
        .join(", ")
}

impl fmt::Display for Datum {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Index => "the spatial index",
            Self::Neighbours => "neighbours",
            Self::Density => "densities",
            Self::Divergence => "velocities without divergence",
            Self::Forces => "accelerations without pressure",
            Self::Pressure => "pressure forces",
        })
    }
}

impl Order {
    /// The order of `assets/orders/default.ron`.
    pub fn standard() -> Self {
        Self::parse(include_str!("../../assets/orders/default.ron")).unwrap_or(Self {
            stages: Vec::new(),
            allow_stale: false,
        })
    }

    /// Reads an order.
    pub fn parse(text: &str) -> Result<Self, OrderError> {
        read(text, "order").map_err(|error| match error {
            SceneError::Syntax {
                place: Place::File { line, column, .. },
                message,
            } => OrderError::Syntax {
                line,
                column,
                message,
            },
            other => OrderError::Syntax {
                line: 1,
                column: 1,
                message: other.to_string(),
            },
        })
    }

    /// Checks that every stage the scene wants finds what it needs.
    pub fn check(&self, scene: &Scene) -> Result<(), OrderError> {
        let mut checker = Checker {
            scene,
            allow_stale: self.allow_stale,
            current: Vec::new(),
            made: Vec::new(),
            integrates: false,
        };
        checker.items(&self.stages)?;
        if checker.integrates {
            Ok(())
        } else {
            Err(OrderError::NeverIntegrates)
        }
    }
}

/// What a step has made so far.
struct Checker<'a> {
    scene: &'a Scene,
    allow_stale: bool,
    current: Vec<Datum>,
    made: Vec<Datum>,
    integrates: bool,
}

impl Checker<'_> {
    fn items(&mut self, items: &[OrderItem]) -> Result<(), OrderError> {
        for item in items {
            match item {
                OrderItem::Run(name) => self.stage(Stage::find(name)?)?,
                OrderItem::Every(0, _) => return Err(OrderError::ZeroCount { item: "Every" }),
                OrderItem::Repeat(0, _) => return Err(OrderError::ZeroCount { item: "Repeat" }),
                OrderItem::Repeat(count, items) => {
                    (0..*count).try_for_each(|_| self.items(items))?
                }
                OrderItem::Every(count, items) => {
                    let before = self.current.clone();
                    self.items(items)?;
                    if *count > 1 {
                        // In the steps between, what these stages make is left over.
                        self.current.retain(|datum| before.contains(datum));
                    }
                }
            }
        }
        Ok(())
    }

    fn stage(&mut self, stage: &'static Stage) -> Result<(), OrderError> {
        if !(stage.wanted)(self.scene) {
            return Ok(());
        }
        for &datum in stage.needs {
            let exists = self.made.contains(&datum);
            // What no stage makes in this scene (lists, where neighbours are recomputed) nobody lacks.
            let Some(maker) = Stage::ALL
                .iter()
                .find(|s| s.makes.contains(&datum) && (s.wanted)(self.scene))
            else {
                continue;
            };
            let usable = self.current.contains(&datum) || exists && self.allow_stale;
            if !usable {
                let (stage, maker) = (stage.name, maker.name);
                return Err(OrderError::Lacks {
                    stage,
                    datum,
                    maker,
                    stale: exists,
                });
            }
            if !self.current.contains(&datum)
                && matches!(self.scene.time_step, TimeStep::Adaptive(_))
            {
                let stage = stage.name;
                return Err(OrderError::CannotGoBack { stage, datum });
            }
        }
        if stage.spoils_all {
            self.integrates |= stage.name == "integrate";
            self.current.clear();
        }
        self.current.extend(stage.makes);
        self.made.extend(stage.makes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        ron::from_str(
            "(name: \"t\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))])",
        )
        .expect("a scene")
    }

    fn check(stages: &str) -> Result<(), String> {
        Order::parse(stages)
            .and_then(|order| order.check(&scene()))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn the_default_order_is_in_order() {
        assert!(!Order::standard().stages.is_empty());
        assert_eq!(Order::standard().check(&scene()), Ok(()));
    }

    #[test]
    fn wrong_orders_are_refused_with_the_reason() {
        let all = r#"Run("rebuild_index"), Run("find_neighbours"), Run("density"), Run("gravity"), Run("viscosity")"#;
        for (stages, expected) in [
            (
                r#"(stages: [Run("densty")])"#.to_owned(),
                "did you mean `density`?",
            ),
            (
                r#"(stages: [Run("rebuild_index"), Run("density")])"#.to_owned(),
                "stage `density` needs neighbours",
            ),
            (
                r#"(stages: [Run("find_neighbours")])"#.to_owned(),
                "`rebuild_index` makes it",
            ),
            (
                format!("(stages: [{all}, Run(\"pressure\")])"),
                "never runs `integrate`",
            ),
            (
                format!("(stages: [{all}, Run(\"integrate\")])"),
                "stage `integrate` needs pressure forces",
            ),
            (
                r#"(stages: [Every(0, [Run("density")])])"#.to_owned(),
                "count of 0",
            ),
            ("(stages: [Run(density)])".to_owned(), "1:"),
        ] {
            let error = check(&stages).expect_err(&stages);
            assert!(error.contains(expected), "{stages}: {error}");
        }
    }

    #[test]
    fn stale_data_is_an_experiment_that_must_be_asked_for() {
        let order = r#"(stages: [Run("rebuild_index"), Every(2, [Run("find_neighbours")]), Run("density"), Run("gravity"),
            Run("viscosity"), Run("pressure"), Run("integrate")]"#;
        let error = check(&format!("{order})")).expect_err("stale lists");
        assert!(
            error.contains("left over") && error.contains("allow_stale"),
            "{error}"
        );
        assert_eq!(check(&format!("{order}, allow_stale: true)")), Ok(()));
    }
}
