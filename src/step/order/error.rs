//! Why an order is refused.

use crate::state::Product;

/// Largest number of stages in a step: the time to build a schedule grows with its square.
pub(super) const MOST_STAGES: u64 = 256;

/// Why an order is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OrderError {
    /// The file is not a valid order.
    #[error("{message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        message: String,
    },
    /// No stage has this name.
    #[error("no stage is called `{name}`{}; the stages are {}", suggestion(name, known), known.join(", "))]
    UnknownStage {
        /// The name.
        name: String,
        /// The names that exist.
        known: Vec<&'static str>,
    },
    /// A count of zero.
    #[error("`{item}` with a count of 0 never runs; the least is 1")]
    ZeroCount {
        /// `Every`, `Repeat`, `Group` or `SubSteps`.
        item: &'static str,
    },
    /// A stage lacks a product that another stage makes.
    #[error(
        "stage `{stage}` needs {product}, {}; stage `{maker}` makes it and must come before{}",
        if *.stale { "left over from an earlier step there" } else { "which nothing has made" },
        if *.stale && *.product != Product::Columns { " (or say `allow_stale: true`)" } else { "" }
    )]
    Lacks {
        /// The stage.
        stage: &'static str,
        /// The product that is missing.
        product: Product,
        /// The stage that makes it.
        maker: &'static str,
        /// Whether it exists but is out of date.
        stale: bool,
    },
    /// A stage uses a product of an earlier step, which `Adaptive` may have rolled back.
    #[error(
        "stage `{stage}` uses {product} left over from an earlier step, which `time_step: Adaptive` may have taken \
         back; use `Cfl` or `Fixed`"
    )]
    CannotGoBack {
        /// The stage.
        stage: &'static str,
        /// The stale product.
        product: Product,
    },
    /// A stage uses a product of an earlier step by row, and rows have been reordered since.
    #[error(
        "stage `{stage}` uses {product} left over from an earlier step, and `reorder`, every {period} steps, gives \
         the rows to other particles in between; run `{maker}` in every step or in every n-th, where n divides \
         {period}, or set the scene's `reorder_interval` to 0"
    )]
    RowsMove {
        /// The stage.
        stage: &'static str,
        /// The stale product.
        product: Product,
        /// The stage that makes it.
        maker: &'static str,
        /// Steps between two reorderings.
        period: u64,
    },
    /// No stage moves the particles.
    #[error("the order never runs `integrate`: time would stand still")]
    NeverIntegrates,
    /// Time would advance only in some steps.
    #[error(
        "`integrate` is inside `Every({count}, …)`: it alone counts the steps, so after the first no step would be \
         due; move it out of `Every`, or choose another `time_step`"
    )]
    WaitsForItself {
        /// Number of steps between two runs.
        count: u64,
    },
    /// The counts of nested `Every` multiply to more than a step number can hold.
    #[error(
        "the stages within nested `Every` would run in every {count}th step; at most {} is a count",
        u32::MAX
    )]
    TooRare {
        /// The product of the counts, saturated.
        count: u64,
    },
    /// More stages than [`MOST_STAGES`].
    #[error("a step would run {count} stages; at most {MOST_STAGES} are possible, so repeat less")]
    TooManyStages {
        /// Their number.
        count: u64,
    },
    /// Reordering has two intervals.
    #[error(
        "`reorder` is inside `Every({count}, …)`, and the scene's `reorder_interval` says how often rows are \
         reordered; move it out of `Every`"
    )]
    TwoIntervals {
        /// Number of steps between two runs.
        count: u64,
    },
    /// Particles would come or go within a step.
    #[error(
        "stage `{stage}` changes which particles there are, and the columns of the step hold others; run it after \
         `reorder`, or before `gather`"
    )]
    WithinStep {
        /// The stage.
        stage: &'static str,
    },
    /// Fluid would enter only in some steps.
    #[error(
        "`emit` is inside `Every({count}, …)`: layers would come too late; move it out of `Every`"
    )]
    EntersLate {
        /// Number of steps between two runs.
        count: u64,
    },
    /// An offset that is no step of the group.
    #[error("the offset is {offset} and the group runs every {every} steps; an offset is from 0 to {}", every - 1)]
    Offset {
        /// The offset.
        offset: u32,
        /// Number of steps between two runs.
        every: u32,
    },
    /// A condition without bounds, or with bounds that no value fits.
    #[error(
        "`{condition}` has no range; write `above`, `below` or both, with finite numbers and `above` less than `below`"
    )]
    Condition {
        /// The condition.
        condition: String,
    },
    /// A stage that moves particles or rows depends on a condition.
    #[error("`{stage}` is in a group with a condition; move it out: it has to run in every step")]
    UnderCondition {
        /// The stage.
        stage: &'static str,
    },
    /// A product that a stage needs is made under a condition.
    #[error(
        "stage `{stage}` needs {product}, which stage `{maker}` makes only under a condition; run `{maker}` also in \
         every step or, with `allow_stale: true`, in every n-th"
    )]
    MadeSometimes {
        /// The stage.
        stage: &'static str,
        /// The product.
        product: Product,
        /// The stage that makes it.
        maker: &'static str,
    },
    /// A stage in a group for forces that is no force.
    #[error(
        "stage `{stage}` adds no force; `{group}` is for stages that do (gravity, body_forces, viscosity, \
         surface_tension, a host's), and for nothing within another such group"
    )]
    NoForce {
        /// The stage, or the group.
        stage: &'static str,
        /// `SubSteps` or `InPressure`.
        group: &'static str,
    },
    /// Forces in the iterations of a method without any.
    #[error("`InPressure` needs a pressure method that iterates; `Sesph` does not")]
    NoIterations,
    /// A stage of `WithKernel` whose sums are tied to the density.
    #[error(
        "stage `{stage}` has the kernel of the scene: the pressure force is the gradient of the densities that the \
         solve predicts, and with two kernels neither would energy be conserved nor would iterations converge; write \
         `kernel` and `support` in the scene, or move the stage out of `WithKernel`"
    )]
    KernelOfDensity {
        /// The stage.
        stage: &'static str,
    },
    /// A stage of `WithKernel` without sums over pairs.
    #[error(
        "`{stage}` has no kernel of its own; `WithKernel` is for viscosity, surface_tension and a host's stages that \
         declare one, each within one `WithKernel`"
    )]
    NoKernelOfItsOwn {
        /// The stage.
        stage: &'static str,
    },
    /// Viscosity has another kernel than the friction of the walls.
    #[error(
        "stage `viscosity` in `WithKernel`: the walls of the scene hold the fluid (`slip`) with a friction that is \
         made for the scene's kernel; move the stage out, or let the fluid slip"
    )]
    KernelOfWalls,
    /// The support of `WithKernel` is no support within the lists.
    #[error(
        "the support is {support} spacings; it must be from {least} (below, a particle has too few neighbours) to that \
         of the scene, {most}, within which neighbours are found"
    )]
    Support {
        /// The support in spacings.
        support: f32,
        /// The least.
        least: f32,
        /// That of the scene.
        most: f32,
    },
    /// The kernel of a stage has a shorter time step than the scene allows.
    #[error(
        "with this kernel stage `{stage}` needs steps of {limit:.2e} s or less, and the least time step of the scene \
         is {min:e} s; write a smaller `min` in `time_step`, or a larger `support` here"
    )]
    KernelNeedsShortSteps {
        /// The stage.
        stage: &'static str,
        /// Limit of the time step \[s].
        limit: f32,
        /// Least time step of the scene \[s].
        min: f32,
    },
    /// The order lacks a stage that the scene asks for.
    #[error(
        "the order never runs `{stage}`, which the scene asks for; add `Run(\"{stage}\")`, or say `leave_out: \
         [\"{stage}\"]` if it is to be missing"
    )]
    LeavesOut {
        /// The stage.
        stage: &'static str,
    },
    /// The order both runs a stage and names it in `leave_out`.
    #[error("the order runs `{stage}` and names it in `leave_out`; remove one")]
    RunsAndLeavesOut {
        /// The stage.
        stage: &'static str,
    },
}

fn suggestion(name: &str, known: &[&str]) -> String {
    (known.iter())
        .map(|known| (strsim::damerau_levenshtein(name, known), known))
        .min()
        .filter(|(distance, _)| *distance <= 3)
        .map_or_else(String::new, |(_, near)| format!("; did you mean `{near}`?"))
}
