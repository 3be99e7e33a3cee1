//! `overfall advise`: the cheapest settings of a scene that hold an error.

use std::fmt::Write as _;
use std::ops::ControlFlow;

use overfall::trial::{Advice, AdviceError, Asked, TrialError, Tried, advise as find};
use serde_json::{Value, json};

use super::exit::{Exit, Failure};
use super::stages::Display;
use super::waiting::waiting;
use super::{console, interrupt, options, report};

/// Wall time of the reference at most \[s].
const SECONDS: f64 = 600.0;

/// Tries settings of a scene and prints the cheapest that hold the error.
pub(super) fn advise(options: &options::Advise) -> Result<Exit, Failure> {
    let quiet = options.reporting.quiet;
    let scene = waiting("reading the scene", quiet, || options.scene.load())?;
    let asked = Asked {
        error: options.error,
        measure: options.measure.clone(),
        time: options.time.map(f64::from),
        threads: options.scene.threads(),
        seconds: SECONDS,
    };
    let mut display = Display::start(quiet);
    interrupt::listen(display.announcer())?;
    let found = find(&scene, &asked, &mut |what, fraction| {
        display.step("trying", what, fraction);
        if interrupt::asked() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    display.finish();
    let advice = match found {
        Ok(advice) => advice,
        Err(AdviceError::Trial(TrialError::Asked)) => return Ok(Exit::Interrupted),
        Err(AdviceError::Trial(TrialError::Refused(error))) => {
            return Err(options.scene.refuse(&error));
        }
        Err(AdviceError::Measure(error)) => return Err(Failure::Refused(error)),
        Err(error) => return Err(Failure::Failed(format!("the reference: {error}"))),
    };
    let text = if options.reporting.json {
        report::pretty(&as_json(&asked, &advice))?
    } else {
        text(&asked, &advice)
    };
    console::print(&text)?;
    match advice.chosen {
        Some(_) => Ok(Exit::Done),
        None => Err(Failure::Failed(format!(
            "no setting holds {} % of `{}`; a smaller spacing changes nothing of that, a larger --error does",
            100.0 * asked.error,
            asked.measure
        ))),
    }
}

fn text(asked: &Asked, advice: &Advice) -> String {
    let mut text = format!(
        "Trials of {:.4} s; errors of `{}`, from DFSPH with a density error of 1e-5 and half the time step ({:.3} \
         s/s).\nThe \
         spacing stays as it is: its error is in all of them.\n\n",
        advice.time, asked.measure, advice.reference_cost
    );
    for (k, tried) in advice.tried.iter().enumerate() {
        let mark = if advice.chosen == Some(k) { "*" } else { " " };
        let set = tried.setting.set.join(", ");
        let _ = match &tried.outcome {
            Ok((error, cost)) => writeln!(
                text,
                "{mark} {:>9.3} % {cost:>10.3} s/s  {set}",
                100.0 * error
            ),
            Err(TrialError::OutOfTime { .. }) => {
                writeln!(text, "{mark} {:>11} {:>14}  {set}", "-", "costs more")
            }
            Err(error) => writeln!(text, "{mark} {:>11} {:>14}  {set}: {error}", "-", "failed"),
        };
    }
    let Some(chosen) = advice.chosen.map(|k| &advice.tried[k]) else {
        return text;
    };
    let _ = writeln!(
        text,
        "\nThe cheapest that hold {} %:\n",
        100.0 * asked.error
    );
    for line in chosen.setting.lines() {
        let _ = writeln!(text, "    {line}");
    }
    let _ = match advice.next_cheaper().map(|next| (next, &next.outcome)) {
        Some((next, Ok((error, cost)))) => writeln!(
            text,
            "\nThe next cheaper, {}, has {:.3} % for {cost:.3} s/s.",
            next.setting.set.join(", "),
            100.0 * error
        ),
        _ => writeln!(text, "\nNone of the others is cheaper."),
    };
    text
}

/// The same for programs.
fn as_json(asked: &Asked, advice: &Advice) -> Value {
    let tried = |tried: &Tried| {
        let found = tried.outcome.as_ref().ok();
        json!({
            "set": tried.setting.set,
            "error": found.map(|found| found.0),
            "cost": found.map(|found| found.1),
            "failure": tried.outcome.as_ref().err().map(ToString::to_string),
        })
    };
    json!({
        "measure": asked.measure,
        "error": asked.error,
        "time_s": advice.time,
        "reference_cost": advice.reference_cost,
        "tried": advice.tried.iter().map(tried).collect::<Vec<_>>(),
        "chosen": advice.chosen,
        "lines": advice.chosen.map(|k| advice.tried[k].setting.lines()),
    })
}
