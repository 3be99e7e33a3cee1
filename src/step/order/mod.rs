//! The order of the stages as data: a RON file, checked before anything runs.

mod check;
mod condition;
mod error;
mod events;
mod file;
mod item;
mod plan;

pub(crate) use condition::Due;
pub(super) use condition::{Compared, Decisions};
pub use condition::{Condition, Range};
pub use error::OrderError;
pub(super) use events::{Event, Kind};
pub(crate) use file::check_order;
pub(super) use file::order_of;
pub use item::{Order, OrderItem};
pub use plan::Flow;
pub(super) use plan::{PlannedOrder, limits_of};

#[cfg(test)]
mod tests {
    use super::*;

    use crate::{registry::Stages, scene::Scene};

    fn scene() -> Scene {
        ron::from_str(
            "(name: \"t\", spacing: 0.1, pressure: Pcisph(()),
              bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))])",
        )
        .expect("a scene")
    }

    fn check(stages: &str) -> Result<(), String> {
        let order = Order::parse(stages).map_err(|error| error.to_string())?;
        let planned = order.plan(&scene(), &Stages::default());
        planned.map(|_| ()).map_err(|(error, _)| error.to_string())
    }

    #[test]
    fn the_default_order_is_in_order() {
        assert!(!Order::standard().stages.is_empty());
        assert!(Order::standard().plan(&scene(), &Stages::default()).is_ok());
    }

    #[test]
    fn wrong_orders_are_refused_with_the_reason() {
        let all = r#"Run("gather"), Run("rebuild_index"), Run("find_neighbours"), Run("density"),
            Run("clear_forces"), Run("gravity"), Run("viscosity")"#;
        for (stages, expected) in [
            (
                r#"(stages: [Run("densty")])"#.to_owned(),
                "did you mean `density`?",
            ),
            (
                r#"(stages: [Run("gather"), Run("rebuild_index"), Run("density")])"#.to_owned(),
                "stage `density` needs neighbours",
            ),
            (
                r#"(stages: [Run("find_neighbours")])"#.to_owned(),
                "`gather` makes it",
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
            ("(stages: [Run(density)])".to_owned(), "double quotes"),
        ] {
            let error = check(&stages).expect_err(&stages);
            assert!(error.contains(expected), "{stages}: {error}");
        }
    }

    #[test]
    fn stale_data_is_an_experiment_that_must_be_asked_for() {
        let order = r#"(leave_out: ["reorder"], stages: [Run("gather"), Run("rebuild_index"), 
            Every(2, [Run("find_neighbours")]), Run("density"),
            Run("clear_forces"), Run("gravity"), Run("viscosity"), Run("pressure"), Run("integrate")]"#;
        let error = check(&format!("{order})")).expect_err("stale lists");
        assert!(
            error.contains("left over") && error.contains("allow_stale"),
            "{error}"
        );
        assert_eq!(check(&format!("{order}, allow_stale: true)")), Ok(()));
    }
}
