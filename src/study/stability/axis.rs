//! Checks the values of an axis and its overrides.

use super::{Axis, Scale, Values, template};

impl Axis {
    /// Checks values and overrides; whether an edge may be searched depends on the axis. The error has the field of the
    /// axis that is the mistake.
    pub(crate) fn check(&self, may_be_edge: bool) -> Result<(), (String, String)> {
        let wrong = |message: String| Err(("values".to_owned(), message));
        match self.values {
            Values::Edge { .. } if !may_be_edge => {
                return wrong(
                    "an edge is searched along the `y` of a map; list the values here".to_owned(),
                );
            }
            Values::Edge { halvings, .. } if !(1..=30).contains(&halvings) => {
                return wrong(format!(
                    "`halvings` is {halvings}; it must be from 1 to 30 (6 is usual)"
                ));
            }
            Values::Range { count, .. } if !(2..=1000).contains(&count) => {
                return wrong(format!("`count` is {count}; it must be from 2 to 1000"));
            }
            _ => {}
        }
        if let Values::Range { from, .. } = self.values
            && self.scale == Scale::Log
            && from <= 0.0
        {
            return wrong(no_place(from));
        }
        let values = self.known_values();
        let ascend = values.windows(2).all(|pair| pair[0] < pair[1]);
        if values.is_empty() || !ascend || !values.iter().all(|value| value.is_finite()) {
            return wrong("values have to be numbers, one at least, and to ascend".to_owned());
        }
        if self.scale == Scale::Log && values[0] <= 0.0 {
            return wrong(no_place(values[0]));
        }
        for (k, text) in self.set.iter().enumerate() {
            let filled = values.iter().find_map(|&v| template::fill(text, v).err());
            if let Some(message) = filled {
                return Err((format!("set.{k}"), message));
            }
        }
        if self.set.iter().any(|text| template::has_value(text)) {
            return Ok(());
        }
        let message =
            "no override has the value in it; write `{v}` where it belongs, as in `spacing={v}`";
        Err(("set".to_owned(), message.to_owned()))
    }
}

fn no_place(value: f64) -> String {
    format!("{value} has no place on a logarithmic scale; begin above 0, or write `scale: Linear`")
}
