//! Warnings before a run, and the report at its end, as text and as JSON.

use std::fmt::Write;

use overfall::Phase;
use overfall::output::memory::warnings;
use overfall::output::{Status, Summary};
use overfall::scene::Scene;
use serde::Serialize;

use super::exit::Failure;
use super::folder::{CONTACT_SHEET, HISTORY, RunFolder, SUMMARY};
use super::waiting::waiting;
use super::{console, options};

/// Prints what is probably a mistake in a scene.
pub(super) fn warn(options: &options::Run, scene: &Scene) -> Result<(), Failure> {
    let quiet = options.reporting.quiet;
    let warnings = waiting("counting", quiet, || warnings(scene))
        .map_err(|error| options.scene.refuse(&error))?;
    for warning in warnings.iter().filter(|_| !quiet) {
        console::note(&format!("warning: {warning}"));
    }
    Ok(())
}

/// A result as JSON, as it may go to a terminal.
pub(super) fn pretty(result: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(result)
        .map(|text| console::json(&text) + "\n")
        .map_err(|error| Failure::Failed(format!("cannot write the result as JSON: {error}")))
}

/// The summary as text: what was done, how fast, how accurately, and where the files are.
pub(super) fn text(summary: &Summary, scene: &Scene, folder: &RunFolder) -> String {
    // Writing to a String cannot fail, here and below.
    let mut rows = Vec::new();
    rows.push((
        "particles",
        format!(
            "{} fluid, {} boundary",
            summary.particles, summary.boundary_particles
        ),
    ));
    if summary.particles_emitted > 0 || summary.particles_removed > 0 {
        rows.push(("flow", flow(summary)));
    }
    rows.push((
        "step",
        format!(
            "{:.2} ms on average, {:.1} s in all, on {} with {}",
            summary.ms_per_step,
            1e-3 * summary.ms_per_step * summary.steps as f64,
            count(summary.threads as u64, "thread"),
            summary.instruction_set,
        ),
    ));
    rows.push((
        "density error",
        format!(
            "largest {:.3} %, mean {:.4} %, with {:.1} iterations per step",
            100.0 * summary.max_density_error,
            100.0 * summary.mean_density_error,
            summary.mean_iterations
        ),
    ));
    if summary.roll_backs > 0 {
        rows.push((
            "went back",
            format!(
                "{}, {} taken back",
                count(summary.roll_backs, "time"),
                count(summary.steps_taken_back, "step")
            ),
        ));
    }
    if let Some(bytes) = summary.peak_rss_bytes {
        rows.push(("memory", format!("{} at most", size(bytes as f64))));
    }
    rows.push(("frames", frames(summary, scene, folder)));
    if scene.output.pictures {
        let mut pictures = folder.pictures().display().to_string();
        // The sheet is drawn from the frames' files.
        if !scene.output.formats.is_empty() {
            let _ = write!(
                pictures,
                ", all in one: {}",
                folder.path(CONTACT_SHEET).display()
            );
        }
        rows.push(("pictures", pictures));
    }
    rows.push(("summary", folder.path(SUMMARY).display().to_string()));
    rows.push(("history", folder.path(HISTORY).display().to_string()));

    let mut text = headline(summary);
    for (name, value) in rows {
        let _ = writeln!(text, "  {name:<14} {value}");
    }
    if summary.steps > 0 {
        text.push_str(&phase_table(summary));
    }
    text.push_str(&wall_table(summary));
    text
}

/// Where the wall time went, files and pictures included.
fn wall_table(summary: &Summary) -> String {
    let mut parts: Vec<_> = summary.wall_s_by_part.iter().collect();
    parts.sort_by(|a, b| b.1.total_cmp(a.1));
    let mut text = format!("\n  {:<24}{:>8}{:>8}\n", "wall time", "s", "share");
    for (name, &seconds) in parts {
        let share = 100.0 * seconds / summary.wall_s.max(1e-9);
        let _ = writeln!(text, "  {name:<24}{seconds:>8.2}{share:>6.1} %");
    }
    let writes = summary
        .wall_s_by_part
        .keys()
        .any(|name| name.starts_with("writer"));
    if writes {
        text.push_str("  (the writer works beside the steps)\n");
    }
    text
}

fn headline(summary: &Summary) -> String {
    let how = match summary.status {
        Status::Done => "done",
        Status::Interrupted => "interrupted",
        Status::Failed => "failed",
    };
    format!(
        "{}: {how} after {}, {:.4} s simulated in {:.1} s\n",
        console::name(&summary.scene),
        count(summary.steps, "step"),
        summary.simulated_s,
        summary.wall_s
    )
}

fn frames(summary: &Summary, scene: &Scene, folder: &RunFolder) -> String {
    let formats: Vec<_> = (scene.output.formats.iter())
        .map(|format| format.extension())
        .collect();
    if formats.is_empty() {
        return "none written: the scene names no format".to_owned();
    }
    let mut text = format!(
        "{} in {} ({})",
        summary.frames,
        folder.frames().display(),
        formats.join(", ")
    );
    if formats.contains(&"vtu") {
        let _ = write!(
            text,
            ", as a series: {}",
            folder.path(&folder.series()).display()
        );
    }
    text
}

fn phase_table(summary: &Summary) -> String {
    let total: f64 = summary.ms_per_phase.values().sum();
    let mut text = format!("\n  {:<18}{:>10}{:>8}\n", "phase", "ms/step", "share");
    for phase in Phase::ALL {
        let Some(&ms) = summary.ms_per_phase.get(phase.name()) else {
            continue;
        };
        let share = if total > 0.0 { 100.0 * ms / total } else { 0.0 };
        let _ = writeln!(text, "  {:<18}{ms:>10.3}{share:>6.1} %", phase.name());
    }
    text
}

fn count(number: u64, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// A size in bytes, in readable units.
pub(super) fn size(bytes: f64) -> String {
    const UNITS: [&str; 4] = ["bytes", "KiB", "MiB", "GiB"];
    let mut value = bytes;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    let digits = usize::from(unit > 0);
    format!("{value:.digits$} {}", UNITS[unit])
}

/// What came and went.
fn flow(summary: &Summary) -> String {
    let mut text = format!(
        "{} entered, {} removed",
        count(summary.particles_emitted, "particle"),
        count(summary.particles_removed, "particle")
    );
    if summary.particles_without_place > 0 {
        text += &format!(
            ", {} did not enter: other fluid was in their places behind the face",
            count(summary.particles_without_place, "particle")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_read_well() {
        assert_eq!(size(12.0), "12 bytes");
        assert_eq!(size(2048.0), "2.0 KiB");
        assert_eq!(size(3.5 * 1024.0 * 1024.0 * 1024.0), "3.5 GiB");
        assert_eq!(size(5e15), "4656612.9 GiB");
    }
}
