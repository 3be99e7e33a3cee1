//! Lengths of blocks, warm-ups and starts.

use super::Span;

/// No measurement comes to the end of more.
const MOST_STEPS: u64 = 1_000_000_000;
/// The same in simulated time \[s].
const LONGEST: f32 = 1e6;

impl Span {
    /// What is wrong with it, in a sentence.
    pub(super) fn problem(self, may_be_nothing: bool) -> Option<String> {
        let (is_right, value, least) = match self {
            Self::Steps(steps) => (
                (steps > 0 || may_be_nothing) && steps <= MOST_STEPS,
                format!("{steps} steps"),
                "at least 1 step",
            ),
            Self::Time(time) => (
                (time > 0.0 || may_be_nothing && time == 0.0) && time <= LONGEST,
                format!("{time} s"),
                "above 0 s",
            ),
        };
        let least = if may_be_nothing { "not below 0" } else { least };
        (!is_right).then(|| {
            format!(
                "it is {value}; it must be {least}, and at most {MOST_STEPS} steps or {LONGEST} s"
            )
        })
    }
}
