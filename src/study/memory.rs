//! Checks that the machine has the memory that a study needs.

use super::{error::StudyError, plan::PlannedCase};
use crate::{
    memory,
    step::memory::{allowed, need},
};

/// The worlds of all variants of a case are in memory at the same time, so that they can take turns. Returns the field
/// of a case that needs too much memory, and the remedy.
pub(super) fn lacks_memory(cases: &[PlannedCase]) -> Result<Option<(String, String)>, StudyError> {
    let machine = memory::of_machine() as f64;
    for (k, case) in cases.iter().enumerate() {
        let mut needed = 0.0;
        for variant in &case.variants {
            let size = variant.scene.checked_size()?;
            match need(&variant.scene, &size) {
                Ok(need)
                    if need.most > allowed(&variant.scene, machine) && need.most <= machine =>
                {
                    let message = format!(
                        "{} needs about {}, and `memory_limit` is {} GB; raise it, or enlarge the spacing",
                        variant.name,
                        memory::in_words(need.most),
                        variant.scene.memory_limit.unwrap_or_default()
                    );
                    return Ok(Some(("variants".to_owned(), message)));
                }
                Ok(need) => needed += need.most,
                Err(error) => return Ok(Some(("variants".to_owned(), error.to_string()))),
            }
        }
        if needed > machine {
            let path = if case.name.is_empty() {
                "variants".to_owned()
            } else {
                format!("cases.{k}")
            };
            let message = format!(
                "its {} variants are in memory at the same time and need about {}, and there are {}; use fewer, or \
                 `set: [\"spacing=…\"]` with a larger spacing",
                case.variants.len(),
                memory::in_words(needed),
                memory::in_words(machine)
            );
            return Ok(Some((path, message)));
        }
    }
    Ok(None)
}
