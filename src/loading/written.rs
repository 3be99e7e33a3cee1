//! Numbers as a text has them: those that single precision does not carry are refused by what was written, as
//! afterwards they are infinite or zero.

use super::check::Problem;
use super::spans::scan;

/// Refuses a number of a RON text that is another one in single precision: infinite, or zero. `path` leads to the text.
pub(super) fn carried(text: &str, path: &str) -> Result<(), Problem> {
    let Some(tree) = scan(text) else {
        return Ok(());
    };
    let mut found = None;
    tree.leaves(path, &mut |path, leaf| {
        let written = &text[leaf.span.clone()];
        if found.is_none()
            && let Some(what) = lost(written)
        {
            found = Some(Problem::new(
                path,
                format!("`{path}` is {written}, which is {what}"),
            ));
        }
    });
    found.map_or(Ok(()), Err)
}

/// How a number is carried wrongly; nothing for one that is carried, and for what is no number.
fn lost(written: &str) -> Option<&'static str> {
    if !written.contains(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let number: f64 = written.replace('_', "").parse().ok()?;
    let digits = written.split(['e', 'E']).next().unwrap_or_default();
    let is_zero = !digits.contains(|c| matches!(c, '1'..='9'));
    match number as f32 {
        single if single.is_infinite() => {
            Some("beyond single precision; it must be at most 3.4e38")
        }
        0.0 if !is_zero => Some("0 in single precision; write 0, or a number of at least 1.2e-38"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_others_in_single_precision_are_named_as_written() {
        for (written, is_carried) in [
            ("1e300", false),
            ("-3.5e38", false),
            ("1e400", false),
            ("1e-46", false),
            ("-0.1e-400", false),
            ("1_000e36", false),
            ("3.4e38", true),
            ("1.2e-38", true),
            ("0e9", true),
            ("-0.0", true),
            ("18446744073709551615", true),
            ("1_000", true),
            ("\"1e300\"", true),
            ("inf", true),
        ] {
            let text = format!("(name: \"1e400\", limits: (energy: {written}, other: [1, 2]))");
            match carried(&text, "") {
                Ok(()) => assert!(is_carried, "{written}"),
                Err(problem) => {
                    assert!(!is_carried, "{written}");
                    assert_eq!(problem.path, "limits.energy");
                    assert!(problem.message.contains(written), "{}", problem.message);
                }
            }
        }
    }
}
