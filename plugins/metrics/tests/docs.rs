//! docs/metrics.md has the statistics that metrics declare.
//!
//! `MIMESH_WRITE_DOCS=1 cargo test -p mimesh-metrics --test docs` writes the tables anew.

use std::{fs, path::Path};

use mimesh_core::{
    plugin,
    stage::{Aggregate, Metric, Statistic},
};
use mimesh_metrics as _;

/// The first line of every table of statistics.
const HEADING: &str = "| statistic | unit | doubtful / bad | over poses | meaning |";

#[test]
fn the_tables_of_statistics_are_those_that_metrics_declare() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/metrics.md");
    let found = fs::read_to_string(&file).unwrap();
    let expected = with_declared_tables(&found);
    if std::env::var_os("MIMESH_WRITE_DOCS").is_some() {
        fs::write(&file, &expected).unwrap();
    } else {
        assert!(found == expected, "docs/metrics.md has other statistics than the metrics: see this test's head");
    }
    for (name, _) in plugin::instances::<dyn Metric>() {
        let heading = format!("\n## {name}\n");
        let section = expected.split_once(&heading).map(|(_, rest)| rest.split("\n## ").next().unwrap_or_default());
        let tables = section.map(|section| section.matches(HEADING).count());
        assert_eq!(tables, Some(1), "docs/metrics.md: tables of statistics in the section {name}");
    }
}

/// What verdicts call a statistic is read by people who know neither metrics nor statistics.
#[test]
fn statistics_with_limits_have_titles() {
    for (name, metric) in plugin::instances::<dyn Metric>() {
        for statistic in metric.statistics().iter().filter(|statistic| statistic.limits.is_some()) {
            assert!(!statistic.title.is_empty(), "{name}: `{}` has limits and no title", statistic.name);
        }
    }
}

/// `text` with the table of each section replaced by that of the metric which the section is about.
fn with_declared_tables(text: &str) -> String {
    let mut result = String::new();
    let (mut section, mut in_table) = ("", false);
    for line in text.lines() {
        section = line.strip_prefix("## ").unwrap_or(section);
        in_table &= line.starts_with('|');
        if line == HEADING {
            in_table = true;
            let metric = plugin::instance::<dyn Metric>(section);
            let metric = metric.unwrap_or_else(|| panic!("docs/metrics.md: `{section}` is no metric"));
            result += &table(&metric.statistics());
        } else if !in_table {
            result += line;
            result += "\n";
        }
    }
    result
}

fn table(statistics: &[Statistic]) -> String {
    let rows = statistics.iter().map(row).collect::<String>();
    format!("{HEADING}\n|---|---|---|---|---|\n{rows}")
}

fn row(statistic: &Statistic) -> String {
    let Statistic { name, title, unit, aggregate, limits, meaning } = statistic;
    let title = if title.is_empty() { String::new() } else { format!(" In verdicts: {title}.") };
    let limits = limits.map(|limits| format!("{} / {}", limits.doubtful, limits.bad)).unwrap_or_default();
    let aggregate = match aggregate {
        Aggregate::Mean => "mean",
        Aggregate::RootMeanSquare => "root mean square",
        Aggregate::None => "–",
    };
    format!("| `{name}` | {unit} | {limits} | {aggregate} | {}{title} |\n", meaning.replace('|', "\\|"))
}
