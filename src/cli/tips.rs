//! What was meant by arguments that there are not: fields of a scene without `--set`, options of other programs.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use overfall::scene::Scene;

/// Options of other programs, and what does the same here.
const OTHERS: [(&str, &str); 20] = [
    ("--fps", "`--frames-per-second N`"),
    ("--frames", "`--frames-per-second N`"),
    ("--time", "`--duration S`"),
    ("--end", "`--duration S`"),
    ("--t-end", "`--duration S`"),
    ("--output", "`--out DIR`"),
    ("-o", "`--out DIR`"),
    ("-j", "`--threads N`"),
    ("-t", "`--threads N`"),
    ("-n", "`--steps N`"),
    ("-s", "`--set PATH=VALUE`"),
    ("--color", "`--colour QUANTITY`"),
    ("--dry-run", "the command `check`"),
    ("--dt", "`--set time_step=Fixed(S)`"),
    ("--time-step", "`--set time_step=Fixed(S)`"),
    ("--cfl", "`--set time_step.factor=FACTOR`"),
    ("--method", "`--set pressure=METHOD`"),
    ("--solver", "`--set pressure=METHOD`"),
    ("--scene", "the scene's file alone, without an option"),
    ("--continue", "`--resume DIR`"),
];

/// Adds to an error what was meant, if that is known, in place of what clap suggests.
pub(super) fn add(refused: &mut clap::Error, arguments: &[String]) {
    let Some(tip) = tip(refused, arguments) else {
        return;
    };
    refused.insert(
        ContextKind::Suggested,
        ContextValue::StyledStrs(vec![tip.into()]),
    );
}

fn tip(refused: &clap::Error, arguments: &[String]) -> Option<String> {
    let text = |kind: ContextKind| match refused.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    match refused.kind() {
        ErrorKind::InvalidSubcommand => {
            let word = text(ContextKind::InvalidSubcommand)?;
            let is_scene = word.to_lowercase().ends_with(".ron");
            is_scene.then(|| format!("a scene is simulated by `overfall run {word}`"))
        }
        ErrorKind::UnknownArgument => of_argument(text(ContextKind::InvalidArg)?, arguments),
        _ => None,
    }
}

fn of_argument(argument: &str, arguments: &[String]) -> Option<String> {
    if !argument.starts_with('-') {
        if argument.contains('=') {
            return Some(format!("a field of the scene is set by `--set {argument}`"));
        }
        let at = arguments.iter().position(|other| other == argument)?;
        let path = at.checked_sub(1).and_then(|at| arguments.get(at))?;
        let is_set = at >= 2 && arguments[at - 2] == "--set";
        return is_set.then(|| format!("path and value are one word, `--set {path}={argument}`"));
    }
    let known = OTHERS.iter().find(|(name, _)| *name == argument);
    if let Some((_, meant)) = known {
        return Some(format!("here it is {meant}"));
    }
    let field = argument.trim_start_matches('-').replace('-', "_");
    let schema = Scene::json_schema();
    let is_field = schema["properties"].get(&field).is_some();
    is_field.then(|| format!("a field of the scene is set by `--set {field}=VALUE`"))
}
