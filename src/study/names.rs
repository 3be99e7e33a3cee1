//! Names in studies: of their folders, and of what they list.

use std::collections::HashSet;

/// Whether a name can be that of a folder. The error says what would be right.
pub(crate) fn folder_name(name: &str) -> Result<(), String> {
    let is_a_folder =
        !name.trim().is_empty() && !name.contains(['/', '\\']) && name != "." && name != "..";
    if is_a_folder {
        return Ok(());
    }
    Err(format!(
        "the name {name:?} cannot name the output folder; write a word without slashes"
    ))
}

/// Whether there are names, each once. The error has the number of the name, if one of them is the mistake.
pub(crate) fn distinct<'a>(
    names: impl IntoIterator<Item = &'a str>,
    list: &str,
) -> Result<(), (Option<usize>, String)> {
    let mut seen = HashSet::new();
    for (k, name) in names.into_iter().enumerate() {
        if !seen.insert(name) {
            return Err((
                Some(k),
                format!("the name {name:?} is given twice; rows go by it"),
            ));
        }
    }
    if seen.is_empty() {
        return Err((
            None,
            format!("`{list}` is empty; there must be one at least"),
        ));
    }
    Ok(())
}
