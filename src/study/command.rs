//! The command that repeats a run.

use std::path::Path;

/// `overfall run` with a scene and overrides, as a shell takes it, for a number of steps if one is given.
pub(crate) fn of_run(scene: &Path, set: &[String], steps: Option<u64>) -> String {
    let mut words = format!("overfall run {}", quoted(&scene.display().to_string()));
    for change in set {
        words.push_str(&format!(" --set {}", quoted(change)));
    }
    if let Some(steps) = steps {
        words.push_str(&format!(" --steps {steps}"));
    }
    words
}

/// A word in single quotes, if it needs them.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_the_words_as_they_are() {
        let set = [
            "spacing=0.1".to_owned(),
            "pressure=Dfsph(())".to_owned(),
            "name=it's".to_owned(),
        ];
        assert_eq!(
            of_run(Path::new("a/b.ron"), &set, Some(7)),
            r"overfall run a/b.ron --set spacing=0.1 --set 'pressure=Dfsph(())' --set 'name=it'\''s' --steps 7"
        );
    }
}
