//! Classes of a run, and the rules that decide between them.

use serde::{Deserialize, Serialize};

use crate::state::FailureCause;

/// How a run went. The order is that of the rules: the first that holds decides, and `Stable` is what is left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// The scene was refused, or a step for a cause that no time step mends.
    Refused,
    /// A value was not finite, a particle too fast, or the energy grew by more than [`Rules::explosion`].
    Exploded,
    /// Particles are beyond the walls, or left the domain.
    Leaking,
    /// Pressure did not reach its tolerance in too many steps, or the run stopped because of that.
    NotConverged,
    /// The fluid was denser than [`Rules::compression`], or than the scene's limit.
    Compressed,
    /// The energy grew by more than [`Rules::drift`].
    Drifting,
    /// The run took more wall time than [`Rules::seconds`].
    OutOfTime,
    /// None of these.
    Stable,
}

impl Class {
    /// All classes, the best first.
    pub const ALL: [Self; 8] = [
        Self::Stable,
        Self::Drifting,
        Self::Compressed,
        Self::NotConverged,
        Self::Leaking,
        Self::Exploded,
        Self::Refused,
        Self::OutOfTime,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Refused => "refused",
            Self::Exploded => "exploded",
            Self::Leaking => "leaking",
            Self::NotConverged => "not converged",
            Self::Compressed => "compressed",
            Self::Drifting => "drifting",
            Self::OutOfTime => "out of time",
            Self::Stable => "stable",
        }
    }
}

/// Limits between the classes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rules {
    /// Growth of kinetic and potential energy beyond that of the start that is an explosion \[energy of the start].
    pub explosion: f64,
    /// Growth that is a drift \[energy of the start].
    pub drift: f64,
    /// Mean density error of a step that is a compression \[-].
    pub compression: f64,
    /// Part of the particles that may be beyond the walls \[-].
    pub leak: f64,
    /// Part of the steps that may miss the pressure's tolerance \[-].
    pub not_converged: f64,
    /// Wall time of a run \[s].
    pub seconds: f64,
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            explosion: 1.0,
            drift: 0.02,
            compression: 0.05,
            leak: 0.0,
            not_converged: 0.05,
            seconds: 60.0,
        }
    }
}

/// What is known of a run after some steps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observed {
    /// Steps taken.
    pub steps: u64,
    /// Simulated time \[s].
    pub time: f64,
    /// Wall time of the steps \[s].
    pub wall: f64,
    /// Largest growth of the energy so far \[energy of the start]; 0 if the start has none.
    pub energy_gain: f64,
    /// Largest mean density error of a step \[-].
    pub mean_density_error: f64,
    /// Largest density error \[-].
    pub largest_density_error: f64,
    /// Part of the particles that are beyond the walls, or gone \[-].
    pub leaked: f64,
    /// Steps that missed the pressure's tolerance.
    pub not_converged: u64,
    /// Pressure iterations of all steps.
    pub iterations: u64,
    /// Why the run ended early.
    pub end: Option<End>,
}

/// Why a run ended before its last step.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The scene, in words.
    Refused(String),
    /// A step.
    Failed(Class, String),
    /// The wall time.
    OutOfTime,
}

impl End {
    /// A step that failed.
    pub fn of(cause: &FailureCause) -> Self {
        let class = match cause {
            FailureCause::NotFinite { .. }
            | FailureCause::TooFast { .. }
            | FailureCause::EnergyGained { .. }
            | FailureCause::DomainTooLarge(_)
            | FailureCause::TooLarge { .. }
            | FailureCause::Shock(_) => Class::Exploded,
            // Lists overflow where particles lie on top of each other.
            FailureCause::OverCompressed { .. }
            | FailureCause::ListsTooLong(_)
            | FailureCause::NoRoom { .. } => Class::Compressed,
            FailureCause::LeftDomain => Class::Leaking,
            FailureCause::NotConverged { .. } => Class::NotConverged,
            _ => Class::Refused,
        };
        Self::Failed(class, cause.to_string())
    }

    /// In words.
    pub fn reason(&self) -> String {
        match self {
            Self::Refused(reason) | Self::Failed(_, reason) => reason.clone(),
            Self::OutOfTime => "the wall time of a point was over".to_owned(),
        }
    }
}

impl Rules {
    /// The class of what was observed.
    pub fn class(&self, seen: &Observed) -> Class {
        match &seen.end {
            Some(End::Refused(_)) => return Class::Refused,
            Some(End::Failed(class, _)) => return *class,
            Some(End::OutOfTime) | None => {}
        }
        let missed = seen.not_converged as f64 / seen.steps.max(1) as f64;
        // What is not a number is beyond every limit.
        let beyond = |value: f64, limit: f64| value > limit || value.is_nan();
        let rules = [
            (beyond(seen.energy_gain, self.explosion), Class::Exploded),
            (beyond(seen.leaked, self.leak), Class::Leaking),
            (beyond(missed, self.not_converged), Class::NotConverged),
            (
                beyond(seen.mean_density_error, self.compression),
                Class::Compressed,
            ),
            (beyond(seen.energy_gain, self.drift), Class::Drifting),
            (seen.end.is_some(), Class::OutOfTime),
        ];
        let first = rules.iter().find(|rule| rule.0);
        first.map_or(Class::Stable, |rule| rule.1)
    }

    /// The mistake in a rule, and its name.
    pub(super) fn wrong(&self) -> Option<(&'static str, String)> {
        let all = [
            ("explosion", self.explosion),
            ("drift", self.drift),
            ("compression", self.compression),
            ("leak", self.leak),
            ("not_converged", self.not_converged),
            ("seconds", self.seconds),
        ];
        let wrong = all.iter().find(|(name, value)| {
            !value.is_finite() || *value < 0.0 || *name == "seconds" && *value == 0.0
        });
        if let Some((name, value)) = wrong {
            let least = if *name == "seconds" {
                "above 0"
            } else {
                "0 or above"
            };
            return Some((
                name,
                format!("`{name}` is {value}; it must be a number {least}"),
            ));
        }
        (self.drift > self.explosion).then(|| {
            let message = format!(
                "a drift begins at {} of the energy, and an explosion at {}; that must be more",
                self.drift, self.explosion
            );
            ("drift", message)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each rule by a run that just keeps it and one that breaks it, and the order of the rules.
    #[test]
    fn every_rule_has_its_class_and_its_limit() {
        let rules = Rules::default();
        let at = |change: &dyn Fn(&mut Observed)| {
            let mut seen = Observed {
                steps: 100,
                ..Observed::default()
            };
            change(&mut seen);
            rules.class(&seen)
        };
        assert_eq!(at(&|_| {}), Class::Stable);
        assert_eq!(at(&|seen| seen.energy_gain = rules.drift), Class::Stable);
        assert_eq!(
            at(&|seen| seen.energy_gain = 1.01 * rules.drift),
            Class::Drifting
        );
        assert_eq!(
            at(&|seen| seen.energy_gain = rules.explosion),
            Class::Drifting
        );
        assert_eq!(at(&|seen| seen.energy_gain = f64::NAN), Class::Exploded);
        assert_eq!(at(&|seen| seen.mean_density_error = 0.05), Class::Stable);
        assert_eq!(
            at(&|seen| seen.mean_density_error = 0.051),
            Class::Compressed
        );
        assert_eq!(at(&|seen| seen.not_converged = 5), Class::Stable);
        assert_eq!(at(&|seen| seen.not_converged = 6), Class::NotConverged);
        assert_eq!(at(&|seen| seen.leaked = 1e-3), Class::Leaking);
        assert_eq!(
            at(&|seen| seen.end = Some(End::OutOfTime)),
            Class::OutOfTime
        );
        let refused = |seen: &mut Observed| seen.end = Some(End::Refused("no".into()));
        assert_eq!(at(&refused), Class::Refused);
        // A run that broke a rule before its time was over is of that class.
        let both = |seen: &mut Observed| {
            (seen.end, seen.energy_gain, seen.leaked) = (Some(End::OutOfTime), 2.0, 1.0);
        };
        assert_eq!(at(&both), Class::Exploded);
    }

    #[test]
    fn steps_that_fail_have_the_class_of_their_cause() {
        let class = |cause: FailureCause| match End::of(&cause) {
            End::Failed(class, reason) => {
                assert_eq!(reason, cause.to_string());
                class
            }
            other => panic!("{other:?}"),
        };
        let fast = FailureCause::TooFast {
            displacement: 1.0,
            limit: 0.1,
        };
        let dense = FailureCause::OverCompressed {
            compression: 1.0,
            limit: 0.5,
        };
        let slow = FailureCause::NotConverged {
            iterations: 10,
            error: 0.1,
            limit: 0.01,
        };
        assert_eq!(class(fast), Class::Exploded);
        assert_eq!(
            class(FailureCause::NotFinite { quantity: "x" }),
            Class::Exploded
        );
        assert_eq!(class(dense), Class::Compressed);
        assert_eq!(class(slow), Class::NotConverged);
        assert_eq!(class(FailureCause::LeftDomain), Class::Leaking);
        assert_eq!(class(FailureCause::TimeStep { dt: 0.0 }), Class::Refused);
    }

    #[test]
    fn rules_that_cannot_hold_are_refused() {
        let wrong = |change: &dyn Fn(&mut Rules)| {
            let mut rules = Rules::default();
            change(&mut rules);
            rules.wrong().map(|(name, _)| name)
        };
        assert_eq!(wrong(&|_| {}), None);
        assert_eq!(wrong(&|rules| rules.leak = -1.0), Some("leak"));
        assert_eq!(wrong(&|rules| rules.seconds = 0.0), Some("seconds"));
        assert_eq!(
            wrong(&|rules| rules.compression = f64::NAN),
            Some("compression")
        );
        assert_eq!(wrong(&|rules| rules.explosion = 0.001), Some("drift"));
    }
}
