//! Results of the jobs: for a terminal, as CSV, and as a page.

use std::fmt::Write as _;

use super::{Convergence, Figure, METHODS, Outcome};

/// A number with its significant digits.
fn number(value: f64) -> String {
    if value.is_nan() {
        "—".to_owned()
    } else if value != 0.0 && value.abs() < 1e-3 {
        format!("{value:.2e}")
    } else {
        let digits = (4 - value.abs().max(1.0).log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    }
}

/// A relative error in percent.
fn percent(error: f64) -> String {
    if error.is_finite() {
        format!("{:+.2} %", 100.0 * error)
    } else {
        "—".to_owned()
    }
}

fn heading(outcome: &Outcome) -> String {
    let job = &outcome.job;
    format!(
        "{}, {}, {} particles over the {}: {:.1} s",
        job.case.name, job.method.name, job.resolution, job.case.across, outcome.seconds
    )
}

/// Outcomes for a terminal: measured value, known value and error, one line per figure.
pub fn table<'a>(outcomes: impl IntoIterator<Item = &'a Outcome>) -> String {
    let mut text = String::new();
    for outcome in outcomes {
        let _ = writeln!(text, "{}", heading(outcome));
        match &outcome.result {
            Ok(findings) => {
                for figure in &findings.figures {
                    let (quantity, measured, known) = (
                        &figure.quantity,
                        number(figure.measured),
                        number(figure.known),
                    );
                    let error = percent(figure.error());
                    let _ = writeln!(
                        text,
                        "  {quantity:54} {measured:>10} known {known:>10} error {error:>10}"
                    );
                }
            }
            Err(error) => {
                let _ = writeln!(text, "  could not run to its end: {error}");
            }
        }
    }
    text
}

/// Outcomes as CSV, one row per figure; a failed run has a row without figures.
pub fn csv<'a>(outcomes: impl IntoIterator<Item = &'a Outcome>) -> String {
    let mut text =
        "case,method,resolution,quantity,measured,known,relative_error,failure\n".to_owned();
    let quoted = |words: &str| format!("\"{}\"", words.replace('"', "\"\""));
    for outcome in outcomes {
        let job = &outcome.job;
        let start = format!("{},{},{}", job.case.name, job.method.key, job.resolution);
        match &outcome.result {
            Ok(findings) => {
                for figure in &findings.figures {
                    let quantity = quoted(&figure.quantity);
                    let (measured, known, error) = (figure.measured, figure.known, figure.error());
                    let _ = writeln!(text, "{start},{quantity},{measured},{known},{error},");
                }
            }
            Err(error) => {
                let _ = writeln!(text, "{start},,,,,{}", quoted(&error.to_string()));
            }
        }
    }
    text
}

/// All outcomes as a Markdown page. `charts` are files beside it, each with the name of its case.
pub fn page(
    outcomes: &[&Outcome],
    convergence: &[Convergence],
    charts: &[(String, String)],
) -> String {
    let mut text = "# Measured against what is known\n\nErrors are relative to the known value, or in the unit \
        that the quantity names.\n"
        .to_owned();
    let mut before = "";
    for outcome in outcomes {
        let case = outcome.job.case;
        if case.name == before {
            continue;
        }
        before = case.name;
        let _ = write!(text, "\n## {}\n\n{}\n", case.title, case.texts.1.trim());
        let of_case: Vec<&Outcome> = (outcomes.iter().copied())
            .filter(|outcome| outcome.job.case.name == case.name)
            .collect();
        let mut resolutions: Vec<u32> = of_case.iter().map(|of| of.job.resolution).collect();
        resolutions.sort_unstable();
        resolutions.dedup();
        for resolution in resolutions {
            let (name, across) = (case.name, case.across);
            let _ = write!(
                text,
                "\n`overfall validate {name} --resolution {resolution}`, {resolution} particles over the {across}:\n\n"
            );
            let at: Vec<_> = (of_case.iter().copied())
                .filter(|outcome| outcome.job.resolution == resolution)
                .collect();
            figures(&mut text, &at);
        }
        orders(&mut text, case.name, convergence);
        for (_, file) in charts.iter().filter(|chart| chart.0 == case.name) {
            let _ = write!(text, "\n![{file}]({file})\n");
        }
    }
    text
}

/// A table with one row per quantity and one column per method; below it, the failed runs.
fn figures(text: &mut String, outcomes: &[&Outcome]) {
    let mut quantities: Vec<&Figure> = Vec::new();
    for figure in (outcomes.iter()).flat_map(|of| of.result.iter().flat_map(|f| &f.figures)) {
        if !quantities
            .iter()
            .any(|known| known.quantity == figure.quantity)
        {
            quantities.push(figure);
        }
    }
    if !quantities.is_empty() {
        let names = outcomes.iter().map(|outcome| outcome.job.method.name);
        let names: Vec<_> = names.collect();
        let _ = writeln!(text, "| quantity | known | {} |", names.join(" | "));
        let _ = writeln!(text, "| --- | --- |{}", " --- |".repeat(names.len()));
    }
    for quantity in quantities {
        let _ = write!(
            text,
            "| {} | {} |",
            quantity.quantity,
            number(quantity.known)
        );
        for outcome in outcomes {
            let mut figures = outcome.result.iter().flat_map(|findings| &findings.figures);
            let same = figures.find(|f| f.quantity == quantity.quantity);
            let cell = same.map_or("—".to_owned(), |figure| {
                let measured = number(figure.measured);
                if figure.known == 0.0 {
                    measured
                } else {
                    format!("{measured} ({})", percent(figure.error()))
                }
            });
            let _ = write!(text, " {cell} |");
        }
        text.push('\n');
    }
    for outcome in outcomes {
        if let Err(error) = &outcome.result {
            let name = outcome.job.method.name;
            let _ = write!(text, "\n{name} could not run to its end: {error}\n");
        }
    }
}

/// A table of orders: one row per quantity, one column per method.
fn orders(text: &mut String, case: &str, convergence: &[Convergence]) {
    let of_case = || convergence.iter().filter(|found| found.case.name == case);
    let mut quantities: Vec<&str> = Vec::new();
    for found in of_case() {
        if !quantities.contains(&found.quantity.as_str()) {
            quantities.push(&found.quantity);
        }
    }
    if quantities.is_empty() {
        return;
    }
    let methods: Vec<_> = (METHODS.iter())
        .filter(|method| of_case().any(|found| found.method.key == method.key))
        .collect();
    let names: Vec<_> = methods.iter().map(|method| method.name).collect();
    text.push_str(
        "\nOrder of the error in the spacing, fitted (least to greatest from one resolution to the next). Where an \
         experiment is known, that of the distance to the finest run.\n\n",
    );
    let _ = writeln!(text, "| quantity | {} |", names.join(" | "));
    let _ = writeln!(text, "| --- |{}", " --- |".repeat(names.len()));
    for quantity in quantities {
        let _ = write!(text, "| {quantity} |");
        for method in &methods {
            let mut same = of_case().filter(|found| found.method.key == method.key);
            let order = same.find(|found| found.quantity == quantity);
            let cell = order
                .and_then(|found| found.order)
                .map_or("none".to_owned(), |order| {
                    let [low, high] = order.range;
                    if low == high {
                        format!("{:.1}", order.fitted)
                    } else {
                        format!("{:.1} ({low:.1} to {high:.1})", order.fitted)
                    }
                });
            let _ = write!(text, " {cell} |");
        }
        text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::{CASES, Findings, Job, Stopped};

    #[test]
    fn numbers_have_the_digits_that_say_something() {
        for (value, text) in [
            (8829.0, "8829.0"),
            (0.5, "0.5000"),
            (-123456.0, "-123456"),
            (0.0, "0.0000"),
            (1.25e-6, "1.25e-6"),
            (f64::NAN, "—"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(percent(0.01234), "+1.23 %");
    }

    #[test]
    fn what_could_not_run_is_said_beside_the_others() {
        let job = |method| Job {
            case: CASES[0],
            method: &METHODS[method],
            resolution: 30,
        };
        let good = Findings {
            figures: vec![Figure::exact("depth [m]", 1.1, 1.0)],
            comparisons: Vec::new(),
        };
        let outcomes = [
            Outcome {
                job: job(0),
                seconds: 1.0,
                result: Ok(good),
            },
            Outcome {
                job: job(1),
                seconds: 1.0,
                result: Err(Stopped::Refused("no".to_owned())),
            },
        ];
        let all: Vec<&Outcome> = outcomes.iter().collect();
        let page = page(&all, &[], &[(CASES[0].name.to_owned(), "a.svg".to_owned())]);
        for expected in [
            "| depth [m] | 1.0000 | 1.1000 (+10.00 %) | — |",
            "SESPH, Tait could not run to its end: no",
            "![a.svg](a.svg)",
        ] {
            assert!(page.contains(expected), "{expected}\n{page}");
        }
        let table = table(&outcomes);
        assert!(
            table.contains("error   +10.00 %") && table.contains("could not run"),
            "{table}"
        );
        let csv = csv(&outcomes);
        assert!(
            csv.contains("hydrostatic_2d,sesph-gas,30,\"depth [m]\",1.1,1,0.1"),
            "{csv}"
        );
        assert!(csv.ends_with(",,,,,\"no\"\n"), "{csv}");
    }
}
