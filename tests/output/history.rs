//! The history of a run has one complete row per step, whatever happens; and its summary.

use std::fs;

use overfall::output::{History, OutputError};
use overfall::{Phase, StepReport};

fn report(step: u64) -> StepReport {
    let mut report = StepReport::default();
    report.step = step;
    report.time = step as f64 * 0.001;
    report.dt = 0.001;
    report.phase_seconds = [0.002; Phase::ALL.len()];
    report
}

#[test]
fn the_history_has_a_row_a_step_under_a_header_with_units() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("history.csv");
    let mut history = History::create(&path)?;
    (1..=5).try_for_each(|step| history.push(&report(step)))?;
    history.flush()?;

    let text = fs::read_to_string(&path).unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines.len(), 6);
    for name in [
        "t_s",
        "dt_s",
        "kinetic_energy_J",
        "rebuild_index_ms",
        "observe_ms",
    ] {
        assert!(lines[0].split(',').any(|column| column == name), "{name}");
    }
    for line in &lines {
        assert_eq!(line.split(',').count(), lines[0].split(',').count());
    }
    assert!(lines[5].starts_with("5,0.005,1e-3,"), "{}", lines[5]);
    assert!(lines[5].ends_with(",2.0000"), "{}", lines[5]);
    Ok(())
}

#[test]
fn a_dropped_history_is_complete() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("history.csv");
    let mut history = History::create(&path)?;
    history.push(&report(1))?;
    drop(history);
    assert_eq!(fs::read_to_string(&path).unwrap().lines().count(), 2);
    Ok(())
}

#[test]
fn a_resumed_history_keeps_the_rows_up_to_its_step() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("history.csv");
    let mut history = History::create(&path)?;
    (1..=9).try_for_each(|step| history.push(&report(step)))?;
    drop(history);
    // A file that was truncated within a row, as on a full disk.
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() - 20]).unwrap();

    for (last_kept, expected) in [(20, 9), (4, 5)] {
        let mut history = History::resume(&path, last_kept)?;
        history.push(&report(last_kept + 1))?;
        drop(history);
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().skip(1).count(), expected);
        assert!(text.ends_with('\n'));
    }

    let absent = folder.path().join("absent.csv");
    drop(History::resume(&absent, 4)?);
    assert_eq!(fs::read_to_string(&absent).unwrap().lines().count(), 1);
    Ok(())
}

#[cfg(feature = "cli")]
mod summary {
    use overfall::output::{RunTotals, Status, Summary};

    use super::*;

    #[test]
    fn a_summary_holds_means_over_the_steps_and_is_read_back() -> Result<(), OutputError> {
        let mut totals = RunTotals::default();
        for (step, iterations, error) in [(1, 3, 0.01), (2, 6, 0.005)] {
            let mut report = report(step);
            report.iterations = iterations;
            report.max_density_error = error;
            report.particles = 10;
            totals.add(&report);
        }
        let summary = Summary {
            scene: "dam_break".to_owned(),
            status: Status::Failed,
            failure: Some("step 3: too fast".to_owned()),
            ..totals.summary()
        };
        assert_eq!((summary.steps, summary.particles), (2, 10));
        assert_eq!(summary.mean_iterations, 4.5);
        assert_eq!(summary.max_density_error, 0.01);
        assert!((summary.ms_per_step - 16.0).abs() < 1e-9);
        assert!((summary.ms_per_phase["density"] - 2.0).abs() < 1e-9);
        #[cfg(target_os = "linux")]
        assert!(summary.peak_rss_bytes.is_some_and(|bytes| bytes > 1 << 20));

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary.json");
        summary.write(&path)?;
        assert_eq!(Summary::read(&path)?, summary);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains("\"status\": \"failed\""), "{text}");
        fs::write(&path, "{\"steps\": 3").unwrap();
        assert!(matches!(
            Summary::read(&path),
            Err(OutputError::Malformed { .. })
        ));
        Ok(())
    }
}
