//! The order of the stages as data: a RON file, checked before anything runs.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::stage::{Datum, Stage};
use crate::{
    loading::read,
    scene::{Place, Scene, SceneError},
};

/// An order file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Order {
    /// The stages, one after the other.
    pub stages: Vec<OrderItem>,
    /// Whether a stage may use what was current in an earlier step: an experiment, not an error.
    #[serde(default)]
    pub allow_stale: bool,
    /// Stages that the scene has a use for and that shall not run: what they add is missing, then.
    #[serde(default)]
    pub leave_out: Vec<String>,
}

/// A line of an order file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum OrderItem {
    /// A stage by its name.
    Run(String),
    /// Stages that run in the first and then in every so-manieth step; and in one that finds other particles in the
    /// rows, since a host spawned, despawned or tagged some.
    Every(u32, Vec<OrderItem>),
    /// Stages that run so many times in a row.
    Repeat(u32, Vec<OrderItem>),
}

/// Stages of a step at most: the time to build a schedule grows with the square of their number.
pub(super) const MOST_STAGES: u64 = 256;

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
    /// A stage uses what an earlier step left behind by row, and rows have moved since.
    #[error(
        "stage `{stage}` uses {datum} left over from an earlier step, and `reorder`, every {period} steps, gives the rows to \
         other particles in between; run `{maker}` in every step or in every n-th, where n divides {period}, or set the \
         scene's `reorder_interval` to 0"
    )]
    RowsMove {
        /// The stage.
        stage: &'static str,
        /// What is left over.
        datum: Datum,
        /// The stage that makes it.
        maker: &'static str,
        /// Steps between two reorderings.
        period: u64,
    },
    /// No stage moves the particles.
    #[error("the order never runs `integrate`: time would stand still")]
    NeverIntegrates,
    /// Time advances in some steps alone.
    #[error(
        "`integrate` is inside `Every({count}, …)`: it alone counts the steps, so after the first no step would be due; \
         move it out of `Every`, or choose another `time_step`"
    )]
    WaitsForItself {
        /// Every so-manieth step.
        count: u64,
    },
    /// Nested `Every` multiply to more than a step's number.
    #[error(
        "the stages within nested `Every` would run in every {count}th step; at most {} is a count",
        u32::MAX
    )]
    TooRare {
        /// The product, or the largest number that can be told.
        count: u64,
    },
    /// More stages than a schedule is meant for.
    #[error("a step would run {count} stages; at most {MOST_STAGES} are possible, so repeat less")]
    TooManyStages {
        /// How many.
        count: u64,
    },
    /// A stage that the scene has a use for is not in the order.
    #[error(
        "the order never runs `{stage}`, which the scene has a use for; add `Run(\"{stage}\")`, or say `leave_out: \
         [\"{stage}\"]` if it shall be missing"
    )]
    LeavesOut {
        /// The stage.
        stage: &'static str,
    },
    /// A stage is run and left out.
    #[error("the order runs `{stage}` and names it in `leave_out`; remove one")]
    RunsAndLeavesOut {
        /// The stage.
        stage: &'static str,
    },
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
            leave_out: Vec::new(),
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

    /// Checks that every stage the scene wants is there and finds what it needs.
    pub fn check(&self, scene: &Scene) -> Result<(), OrderError> {
        super::order_check::check(self, scene)
    }
}

impl OrderItem {
    /// Stages that it runs in a step at most.
    pub(super) fn stages(&self) -> u64 {
        match self {
            Self::Run(_) => 1,
            Self::Every(_, items) => stages(items),
            Self::Repeat(count, items) => u64::from(*count).saturating_mul(stages(items)),
        }
    }
}

/// Stages that `items` run in a step at most.
pub(super) fn stages(items: &[OrderItem]) -> u64 {
    let counts = items.iter().map(OrderItem::stages);
    counts.fold(0, u64::saturating_add)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        ron::from_str(
            "(name: \"t\", spacing: 0.1, pressure: Pcisph(()),
              bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))])",
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
        let order = r#"(leave_out: ["reorder"], stages: [Run("rebuild_index"), Every(2, [Run("find_neighbours")]), Run("density"),
            Run("gravity"), Run("viscosity"), Run("pressure"), Run("integrate")]"#;
        let error = check(&format!("{order})")).expect_err("stale lists");
        assert!(
            error.contains("left over") && error.contains("allow_stale"),
            "{error}"
        );
        assert_eq!(check(&format!("{order}, allow_stale: true)")), Ok(()));
    }
}
