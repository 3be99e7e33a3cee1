//! Checks the numbers of a study file, and that what its columns name exists.

use super::check::Checker;
use super::plan::PlannedCase;
use super::{Measure, Reference, Span, StudyError};

/// Largest number of blocks: each is kept in memory until the end.
const MOST_BLOCKS: u32 = 10_000;

impl Checker<'_> {
    pub(super) fn check_numbers(&self) -> Result<(), StudyError> {
        let study = self.study;
        if !(1..=MOST_BLOCKS).contains(&study.blocks) {
            let message = format!(
                "`blocks` is {}; it must be at least 1 and at most {MOST_BLOCKS} (5 is usual)",
                study.blocks
            );
            return self.refuse("blocks", message);
        }
        self.check_span("block", study.block, false)?;
        self.check_span("warm_up", study.warm_up, true)?;
        let starts = study.start.iter().map(|start| ("start".to_owned(), start));
        let of_cases = (0..).zip(&study.cases).filter_map(|(k, case)| {
            (case.start.as_ref()).map(|start| (format!("cases.{k}.start"), start))
        });
        for (path, start) in starts.chain(of_cases) {
            self.check_span(&format!("{path}.time"), Span::Time(start.time), false)?;
        }
        for (k, case) in study.cases.iter().enumerate() {
            if let Some(block) = case.block {
                self.check_span(&format!("cases.{k}.block"), block, false)?;
            }
        }
        Ok(())
    }

    fn check_span(&self, path: &str, span: Span, may_be_nothing: bool) -> Result<(), StudyError> {
        match span.problem(may_be_nothing) {
            None => Ok(()),
            Some(message) => self.refuse(path, message),
        }
    }

    /// Checks that the gauges of all columns exist in the scenes of all variants.
    pub(super) fn check_gauges(&self, cases: &[PlannedCase]) -> Result<(), StudyError> {
        for (k, column) in self.study.columns.iter().enumerate() {
            let Measure::Gauge(measure) = &column.measure else {
                continue;
            };
            for variant in cases.iter().flat_map(|case| &case.variants) {
                if let Err(message) = measure.check(&variant.scene) {
                    return self.refuse(&format!("columns.{k}.measure"), message);
                }
            }
        }
        Ok(())
    }

    pub(super) fn check_references(
        &self,
        cases: &[PlannedCase],
        reference: &Reference,
    ) -> Result<(), StudyError> {
        let columns: Vec<&str> = reference.columns.iter().map(String::as_str).collect();
        for (k, column) in self.study.columns.iter().enumerate() {
            if let Some(name) = &column.reference {
                let path = format!("columns.{k}.reference");
                self.check_known(&path, "reference column", name, &columns)?;
            }
        }
        let rows = reference.rows();
        for case in cases {
            for (k, variant) in case.variants.iter().enumerate() {
                if let Some(name) = &variant.reference {
                    let path = format!("variants.{k}.reference");
                    self.check_known(&path, "reference row", name, &rows)?;
                }
            }
        }
        Ok(())
    }

    /// Checks the threads of variants, and that those which cases name exist.
    pub(super) fn check_variants(&self, variants: &[&str]) -> Result<(), StudyError> {
        let study = self.study;
        for (k, variant) in study.variants.iter().enumerate() {
            if variant.threads == Some(0) {
                let message =
                    "no threads; it must be at least 1, or left out for those of the study";
                return self.refuse(&format!("variants.{k}.threads"), message);
            }
        }
        for (k, case) in study.cases.iter().enumerate() {
            let path = format!("cases.{k}.variants");
            if case.variants.as_ref().is_some_and(Vec::is_empty) {
                return self.refuse(
                    &path,
                    "no variant; name one, or leave `variants` out for all",
                );
            }
            for (n, name) in case.variants.iter().flatten().enumerate() {
                self.check_known(&format!("{path}.{n}"), "variant", name, variants)?;
            }
        }
        Ok(())
    }
}
