//! Where a result comes from: program, machine, date, command line.

use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use sysinfo::{CpuRefreshKind, RefreshKind, System};

use crate::simd::InstructionSet;

/// What is needed to repeat a run, beside its scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of overfall.
    pub version: String,
    /// Commit that the program was built from, with `-modified` if files differed from it; `None` if it is not known.
    pub commit: Option<String>,
    /// Name of the processor; `None` if the system does not tell it.
    pub cpu: Option<String>,
    /// Hardware threads of the machine; 0 if unknown.
    pub cores: usize,
    /// Best SIMD path of the machine.
    pub instruction_set: String,
    /// Operating system and architecture.
    pub system: String,
    /// When the run began, in UTC (RFC 3339).
    pub date: String,
    /// The command line, program first.
    pub command: Vec<String>,
}

impl Provenance {
    /// Of this process; `commit` is what its builder knows.
    pub fn of_this_process(commit: Option<&str>) -> Self {
        let cpus = RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing());
        let cpu = System::new_with_specifics(cpus).ok().and_then(|machine| {
            let mut names = machine
                .cpus()
                .iter()
                .map(|cpu| cpu.brand().trim().to_owned());
            names.find(|name| !name.is_empty())
        });
        let command = std::env::args_os();
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: commit
                .filter(|commit| !commit.is_empty())
                .map(str::to_owned),
            cpu,
            cores: std::thread::available_parallelism().map_or(0, |cores| cores.get()),
            instruction_set: InstructionSet::detect().name().to_owned(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            date: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
            command: command
                .map(|word| word.to_string_lossy().into_owned())
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_knows_where_its_results_come_from() {
        let known = Provenance::of_this_process(Some("0123abc"));
        assert_eq!(known.version, env!("CARGO_PKG_VERSION"));
        assert_eq!(known.commit.as_deref(), Some("0123abc"));
        assert!(!known.command.is_empty() && known.cores > 0);
        // 2026-11-30T03:01:00Z
        assert_eq!(known.date.len(), 20, "{}", known.date);
        assert!(known.date.ends_with('Z') && known.date.as_bytes()[10] == b'T');
        assert_eq!(Provenance::of_this_process(Some("")).commit, None);
    }
}
