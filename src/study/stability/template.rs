//! Numbers in overrides: `spacing={0.01*v}`.

/// The override with the value `v` in place of what stands in braces. Errors say what is wrong with them.
pub(crate) fn fill(template: &str, v: f64) -> Result<String, String> {
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once('{') {
        let Some((inside, behind)) = after.split_once('}') else {
            return Err(format!("`{template}` has a `{{` without its `}}`"));
        };
        text.push_str(before);
        let value = evaluate(inside, v).ok_or_else(|| {
            format!(
                "`{{{inside}}}` is no value; write `{{v}}`, a multiple as `{{0.01*v}}`, a power as `{{v^2}}`, or both \
                 as `{{142.9*v^2}}`"
            )
        })?;
        text.push_str(&number(value));
        rest = behind;
    }
    text.push_str(rest);
    Ok(text)
}

/// Whether the value of an axis occurs in the override.
pub(super) fn has_value(template: &str) -> bool {
    template.contains('{')
}

/// `factor * v ^ power`, both of which may be missing.
fn evaluate(text: &str, v: f64) -> Option<f64> {
    let text = text.trim();
    let (factor, term) = match text.split_once('*') {
        Some((factor, term)) => (factor.trim().parse::<f64>().ok()?, term.trim()),
        None => (1.0, text),
    };
    let power = match term.strip_prefix('v')?.trim() {
        "" => 1.0,
        power => power.strip_prefix('^')?.trim().parse::<f64>().ok()?,
    };
    let value = factor * v.powf(power);
    value.is_finite().then_some(value)
}

/// A number as scene files have it: f32 suffices, so seven digits do.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e9).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_put_into_overrides() {
        for (template, v, filled) in [
            ("bodies.0.jitter.seed={v}", 3.0, "bodies.0.jitter.seed=3"),
            ("a={v}, b={ 2 * v }", 0.1, "a=0.1, b=0.2"),
            ("time_step=Fixed({v})", 2e-5, "time_step=Fixed(2e-5)"),
            (
                "pressure=Sesph(equation: Tait(stiffness: {100*v^2}))",
                3.0,
                "pressure=Sesph(equation: Tait(stiffness: 900))",
            ),
            ("x={v^-1}", 4.0, "x=0.25"),
            ("x={0.01*v}", 30.0, "x=0.3"),
            ("spacing=1", 4.0, "spacing=1"),
        ] {
            assert_eq!(fill(template, v).as_deref(), Ok(filled), "{template}");
        }
        for wrong in [
            "a={",
            "a={}",
            "a={w}",
            "a={v*2}",
            "a={2v}",
            "a={v^}",
            "a={1e999*v}",
        ] {
            let message = fill(wrong, 1.0).expect_err(wrong);
            assert!(message.contains('`'), "{message}");
        }
    }
}
