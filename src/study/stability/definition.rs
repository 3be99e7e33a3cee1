//! The types of a stability study's file; their fields are exactly those of the file.

use serde::{Deserialize, Serialize};

use super::Rules;

/// A study that asks where a scene runs well, over two of its values. Every field except `kind`, `name`, `scene` and
/// `variants` has a default; each variant has an `x` and a `y`, its own or the study's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityStudy {
    /// Says that this is such a study.
    pub kind: StabilityKind,
    /// Name of the output folder.
    pub name: String,
    /// Heading of the map; the name if absent.
    #[serde(default)]
    pub title: Option<String>,
    /// Remarks for the reader, printed below the results.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The scene file, relative to the study's folder.
    pub scene: String,
    /// Overrides for all points, each in the form of `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// What is compared: one map each.
    pub variants: Vec<MapVariant>,
    /// The horizontal axis of variants without one.
    #[serde(default)]
    pub x: Option<Axis>,
    /// The vertical axis of variants without one.
    #[serde(default)]
    pub y: Option<Axis>,
    /// Runs of one point that differ by chance alone; one run if absent.
    #[serde(default)]
    pub seeds: Option<Seeds>,
    /// Numbers of steps after which a run is classed, ascending.
    #[serde(default = "default_after")]
    pub after: Vec<u64>,
    /// Limits between the classes.
    #[serde(default)]
    pub rules: Rules,
}

/// Marks the file of a stability study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum StabilityKind {
    /// Points over two axes, each classed.
    Stability,
}

/// A map of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapVariant {
    /// Its name.
    pub name: String,
    /// Overrides, applied after the study's.
    #[serde(default)]
    pub set: Vec<String>,
    /// Replaces the study's `x`.
    #[serde(default)]
    pub x: Option<Axis>,
    /// Replaces the study's `y`.
    #[serde(default)]
    pub y: Option<Axis>,
}

/// A value that is swept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// What it is called on the map.
    pub name: String,
    /// Its unit; none for plain numbers.
    #[serde(default)]
    pub unit: String,
    /// The values.
    pub values: Values,
    /// Whether equal ratios, or equal differences, are equally long on the map, and halved by an edge's search.
    #[serde(default)]
    pub scale: Scale,
    /// Overrides with the value v in them: `{v}`, `{0.01*v}`, `{v^2}` or `{142.9*v^2}` stand for numbers.
    pub set: Vec<String>,
}

/// Values of an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Values {
    /// These, ascending.
    Listed(Vec<f64>),
    /// So many, evenly spread on the scale, both ends included.
    Range {
        /// The least.
        from: f64,
        /// The greatest.
        to: f64,
        /// Their number.
        count: u32,
    },
    /// The edge of what is stable, found by bisection between two values (vertical axis only).
    Edge {
        /// A value that is expected to be stable.
        stable: f64,
        /// A value that is not.
        unstable: f64,
        /// Steps of the bisection: each halves what is between the two.
        halvings: u32,
    },
}

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Scale {
    /// Logarithmic.
    #[default]
    Log,
    /// Linear.
    Linear,
}

/// Runs of one point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seeds {
    /// Seeds.
    pub values: Vec<u32>,
    /// Overrides with `{v}` for the seed, such as `bodies.0.jitter.seed={v}`.
    pub set: Vec<String>,
}

fn default_after() -> Vec<u64> {
    vec![10, 1000]
}

impl StabilityStudy {
    /// Heading of the map.
    pub fn title(&self) -> &str {
        self.title.as_deref().unwrap_or(&self.name)
    }
}

impl Axis {
    /// Name and unit.
    pub fn label(&self) -> String {
        match self.unit.as_str() {
            "" => self.name.clone(),
            unit => format!("{} [{unit}]", self.name),
        }
    }

    /// The values that are known before anything runs: all, or the two ends of an edge's search, ascending.
    pub fn known_values(&self) -> Vec<f64> {
        match &self.values {
            Values::Listed(values) => values.clone(),
            &Values::Range { from, to, count } => (0..count)
                .map(|k| match k {
                    0 => from,
                    k if k + 1 == count => to,
                    k => self
                        .scale
                        .between(from, to, f64::from(k) / f64::from(count - 1)),
                })
                .collect(),
            &Values::Edge {
                stable, unstable, ..
            } => vec![stable.min(unstable), stable.max(unstable)],
        }
    }
}

impl Scale {
    /// The value at a part of the way between two, with four digits, so that it is the same on every machine.
    pub fn between(self, from: f64, to: f64, part: f64) -> f64 {
        let value = match self {
            Self::Log => from * (to / from).powf(part),
            Self::Linear => from + (to - from) * part,
        };
        // What `{:e}` writes is a number.
        format!("{value:.3e}").parse().unwrap_or(value)
    }

    /// Place of a value on an axis.
    pub fn place(self, value: f64) -> f64 {
        match self {
            Self::Log => value.log10(),
            Self::Linear => value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_their_ends_and_even_steps() {
        let mut axis = Axis {
            name: "a".into(),
            unit: String::new(),
            values: Values::Range {
                from: 1.0,
                to: 1000.0,
                count: 4,
            },
            scale: Scale::Log,
            set: Vec::new(),
        };
        assert_eq!(axis.known_values(), [1.0, 10.0, 100.0, 1000.0]);
        axis.scale = Scale::Linear;
        assert_eq!(axis.known_values(), [1.0, 334.0, 667.0, 1000.0]);
        axis.values = Values::Edge {
            stable: 2.0,
            unstable: 1.0,
            halvings: 3,
        };
        assert_eq!(axis.known_values(), [1.0, 2.0]);
    }
}
