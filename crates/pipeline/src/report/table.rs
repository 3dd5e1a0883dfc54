//! The results of several runs as a table: for people, as CSV, as Markdown and as JSON.

use std::path::PathBuf;

use mimesh_core::{plugin, stage::Metric};
use mimesh_document::Diagnostic;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::run_report::Report;
use crate::{
    compose::{Variant, names},
    json::to_value,
    metrics::{Level, primary_statistics},
    text,
};

/// The outcomes of the runs of a file, as a table with a row for each run.
///
/// The columns are its target, each key that the matrix varies, each metric, its time and its status.
#[derive(Debug)]
pub struct Results {
    /// The pipeline's file.
    pub pipeline: PathBuf,
    /// The runs in their order.
    pub rows: Vec<Row>,
}

/// A run.
#[derive(Debug)]
pub struct Row {
    /// What tells it from the others.
    pub variant: Variant,
    /// Where its report is, if it ended well enough to have one.
    pub place: PathBuf,
    /// How it ended.
    pub outcome: RunOutcome,
    /// How long it took on the clock.
    pub seconds: f64,
}

/// How a run ended.
#[derive(Debug)]
pub enum RunOutcome {
    /// It gave results; some poses may have failed.
    Report(Box<Report>),
    /// It gave no results, for these reasons.
    Failed(Vec<Diagnostic>),
}

/// A column of metrics: a metric and one of its statistics.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct Column {
    metric: String,
    statistic: String,
}

impl Row {
    /// `done`, `gate` if a pose breaks one, `partly` or `failed`.
    pub fn status(&self) -> &str {
        match &self.outcome {
            // A part leaves gates to the merge, which sees all poses.
            RunOutcome::Report(report)
                if report.verdict == Some(Level::Failed) && report.status == "done" && report.part.is_none() =>
            {
                "gate"
            }
            RunOutcome::Report(report) => &report.status,
            RunOutcome::Failed(_) => "failed",
        }
    }

    fn verdict(&self) -> Option<Level> {
        match &self.outcome {
            RunOutcome::Report(report) => report.verdict,
            RunOutcome::Failed(_) => None,
        }
    }

    fn metrics(&self) -> Option<&Map<String, Value>> {
        match &self.outcome {
            RunOutcome::Report(report) => Some(&report.metrics),
            RunOutcome::Failed(_) => None,
        }
    }

    /// The average over poses.
    fn average(&self, column: &Column) -> Option<f64> {
        self.metrics()?.get(&column.metric)?.get("average")?.get(&column.statistic)?.as_f64()
    }
}

impl Results {
    /// `done` if every run is, `gate` if all are but for gates, `failed` if every run has, else `partly`.
    pub fn status(&self) -> &'static str {
        match &self.rows.iter().map(Row::status).collect::<Vec<_>>()[..] {
            all if all.iter().all(|status| *status == "done") => "done",
            all if all.iter().all(|status| ["done", "gate"].contains(status)) => "gate",
            all if all.iter().all(|status| *status == "failed") => "failed",
            _ => "partly",
        }
    }

    /// For people: the main figure of `point_error` and of metrics that are not measured by themselves, keys by their short names.
    pub fn table(&self) -> Vec<Vec<String>> {
        let is_shown = |column: &Column| self.is_main(column) && !is_usual(&column.metric);
        let columns: Vec<Column> = self.columns().into_iter().filter(is_shown).collect();
        let several = |metric: &str| columns.iter().filter(|column| column.metric == metric).count() > 1;
        let heading = |column: &Column| match several(&column.metric) || column.statistic != "mean" {
            true => format!("{} {}", column.metric, column.statistic),
            false => column.metric.clone(),
        };
        let headings: Vec<String> = columns.iter().map(heading).collect();
        let value = |row: &Row, i: usize| row.variant.shown.get(i).cloned().unwrap_or_default();
        let figure = |number: f64| format!("{number:.3}");
        self.rows_of(&names::short(&self.keys()), value, &columns, &headings, figure)
    }

    /// For other programs: all figures in full, keys and values as they were written.
    pub fn csv(&self) -> String {
        let columns = self.columns();
        let headings: Vec<String> =
            columns.iter().map(|column| format!("{}.{}", column.metric, column.statistic)).collect();
        let value = |row: &Row, i: usize| {
            let value = row.variant.values.get(i).map(|(_, value)| value);
            value.map(|value| value.as_str().map_or_else(|| value.to_string(), str::to_owned)).unwrap_or_default()
        };
        let rows = self.rows_of(&self.keys(), value, &columns, &headings, |number| number.to_string());
        text::csv(&rows)
    }

    /// For a page: as [`Results::table`].
    pub fn markdown(&self) -> String {
        text::markdown(&self.table(), self.first_number())
    }

    /// As JSON: every run with what tells it from the others, its figures, and its whole report.
    pub fn json(&self) -> Value {
        let row = |row: &Row| {
            let matrix: Map<String, Value> = row.variant.values.iter().cloned().collect();
            let (report, diagnostics) = match &row.outcome {
                RunOutcome::Report(report) => (to_value(report), vec![]),
                RunOutcome::Failed(diagnostics) => (Value::Null, diagnostics.iter().map(Diagnostic::to_json).collect()),
            };
            let place = report.is_object().then(|| row.place.to_string_lossy());
            json!({
                "name": row.variant.name, "target": row.variant.target, "matrix": matrix, "status": row.status(),
                "seconds": row.seconds, "metrics": row.metrics(), "mistakes": diagnostics, "place": place, "report": report,
            })
        };
        json!({
            "mimesh": env!("CARGO_PKG_VERSION"), "status": self.status(), "pipeline": self.pipeline.to_string_lossy(),
            "runs": self.rows.iter().map(row).collect::<Vec<_>>(),
        })
    }

    fn keys(&self) -> Vec<String> {
        let of = |row: &Row| row.variant.values.iter().map(|(key, _)| key.clone()).collect();
        self.rows.first().map(of).unwrap_or_default()
    }

    fn has_targets(&self) -> bool {
        self.rows.iter().any(|row| row.variant.target.is_some())
    }

    /// The first column whose cells are flush right.
    fn first_number(&self) -> usize {
        usize::from(self.has_targets()) + self.keys().len()
    }

    /// The statistics that any run has, in the order of metrics.
    fn columns(&self) -> Vec<Column> {
        let mut columns = Vec::new();
        for (metric, values) in self.rows.iter().filter_map(Row::metrics).flatten() {
            for (statistic, value) in values.get("average").and_then(Value::as_object).into_iter().flatten() {
                let column = Column { metric: metric.clone(), statistic: statistic.clone() };
                // Counts are no measure of results.
                if value.is_f64() && !columns.contains(&column) {
                    columns.push(column);
                }
            }
        }
        columns
    }

    /// Whether a column is a primary statistic of any run.
    fn is_main(&self, column: &Column) -> bool {
        let reports = self.rows.iter().filter_map(|row| match &row.outcome {
            RunOutcome::Report(report) => Some(report),
            RunOutcome::Failed(_) => None,
        });
        let mut main = reports.flat_map(|report| primary_statistics(&report.poses));
        main.any(|main| main.metric == column.metric && main.statistic == column.statistic)
    }

    fn rows_of(
        &self,
        keys: &[String],
        value: impl Fn(&Row, usize) -> String,
        columns: &[Column],
        headings: &[String],
        figure: impl Fn(f64) -> String,
    ) -> Vec<Vec<String>> {
        let target = self.has_targets();
        let mut heading: Vec<String> = target.then(|| "target".into()).into_iter().collect();
        let judged = self.rows.iter().any(|row| row.verdict().is_some());
        let verdict = judged.then(|| "verdict".to_owned());
        let last = verdict.into_iter().chain(["seconds".into(), "status".into()]);
        heading.extend(keys.iter().chain(headings).cloned().chain(last));
        let mut rows = vec![heading];
        for row in &self.rows {
            let mut cells: Vec<String> =
                target.then(|| row.variant.target.clone().unwrap_or_default()).into_iter().collect();
            cells.extend((0..keys.len()).map(|i| value(row, i)));
            cells.extend(columns.iter().map(|column| row.average(column).map(&figure).unwrap_or_else(|| "-".into())));
            if judged {
                cells.push(row.verdict().map_or("-", Level::word).into());
            }
            cells.extend([format!("{:.2}", row.seconds), row.status().into()]);
            rows.push(cells);
        }
        rows
    }
}

/// Whether a metric is one of those whose verdict says enough: measured by itself, and no distance to the truth.
fn is_usual(metric: &str) -> bool {
    metric != "point_error" && plugin::instance::<dyn Metric>(metric).is_some_and(|metric| metric.by_default())
}

#[cfg(test)]
mod tests {
    use mimesh_document::Kind;

    use super::*;

    #[test]
    fn a_cell_with_a_comma_is_quoted_and_a_failed_run_has_no_figures() {
        let variant = Variant {
            name: "a-k=1".into(),
            target: Some("a".into()),
            matrix: Some("k=1".into()),
            values: vec![("x.k".into(), json!([1, 2])), ("x.l".into(), json!("p|q"))],
            shown: vec!["1".into(), "p|q".into()],
        };
        let outcome = RunOutcome::Failed(vec![Diagnostic::new(Kind::BadData, "no")]);
        let rows = vec![Row { variant, place: "run.json".into(), outcome, seconds: 1.0 }];
        let results = Results { pipeline: "p.yaml".into(), rows };
        assert_eq!(results.csv(), "target,x.k,x.l,seconds,status\na,\"[1,2]\",p|q,1.00,failed\n");
        assert_eq!(
            results.markdown(),
            "| target | k | l | seconds | status |\n| --- | --- | --- | ---: | ---: |\n| a | 1 | p\\|q | 1.00 | failed |\n"
        );
        assert_eq!(results.status(), "failed");
        assert_eq!(results.json()["runs"][0]["mistakes"][0]["message"], "no");
    }
}
