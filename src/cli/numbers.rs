//! Numbers of the command line, and what is wrong with one.

/// A larger number of threads is a typing error.
const MAX_THREADS: u64 = 4096;

/// A part: `1%`, `0.5 %`, or the same without the sign.
pub(super) fn percent(text: &str) -> Result<f64, String> {
    let digits = text.trim().trim_end_matches('%').trim_end();
    let value = f64::from(number(digits)?);
    (value > 0.0)
        .then_some(value / 100.0)
        .ok_or_else(|| "it must be above 0, such as 1%".to_owned())
}

pub(super) fn threads(text: &str) -> Result<u64, String> {
    within(text, 1, MAX_THREADS)
}

pub(super) fn resolution(text: &str) -> Result<u32, String> {
    let number = within(text, 2, 10_000)?;
    u32::try_from(number).map_err(|error| error.to_string())
}

fn within(text: &str, least: u64, most: u64) -> Result<u64, String> {
    let number = text.parse().ok();
    number
        .filter(|number| (least..=most).contains(number))
        .ok_or_else(|| format!("it must be a whole number from {least} to {most}"))
}

pub(super) fn whole_number(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| "it must be a whole number, 0 or above, such as 100".to_owned())
}

pub(super) fn positive(text: &str) -> Result<f32, String> {
    let value = number(text)?;
    (value > 0.0)
        .then_some(value)
        .ok_or_else(|| "it must be a number above 0".to_owned())
}

pub(super) fn not_negative(text: &str) -> Result<f32, String> {
    let value = number(text)?;
    (value >= 0.0)
        .then_some(value)
        .ok_or_else(|| "it must be a number, 0 or above".to_owned())
}

fn number(text: &str) -> Result<f32, String> {
    if let Some(value) = text.parse().ok().filter(|value: &f32| value.is_finite()) {
        return Ok(value);
    }
    let (point, digits) = (
        text.replace(',', "."),
        text.trim_end_matches(|c: char| c.is_alphabetic() || c.is_whitespace()),
    );
    Err(if point != text && point.parse::<f32>().is_ok() {
        format!("a number has a decimal point: {point}")
    } else if digits != text && digits.parse::<f32>().is_ok() {
        format!(
            "a number stands alone, in SI units, without `{}`",
            text[digits.len()..].trim()
        )
    } else {
        "it must be a number, and finite".to_owned()
    })
}
