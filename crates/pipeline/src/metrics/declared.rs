//! What metrics declare of their statistics, for people: units and limits.

use mimesh_core::{
    plugin,
    stage::{Metric, Statistic},
};

use crate::text::number;

/// The statistics that a metric declares; empty if it is not linked into this program.
pub fn declared(metric: &str) -> Vec<Statistic> {
    plugin::instance::<dyn Metric>(metric).map(|metric| metric.statistics()).unwrap_or_default()
}

/// A statistic as its metric declares it; `None` if it does not, or is not linked into this program.
pub fn declared_statistic(metric: &str, statistic: &str) -> Option<Statistic> {
    declared(metric).into_iter().find(|declared| declared.name == statistic)
}

/// What people read for a statistic: its title, else its metric and its name, as `point error p95`.
pub fn title(metric: &str, statistic: &str) -> String {
    match declared_statistic(metric, statistic).map_or("", |statistic| statistic.title) {
        "" => key_in_words(metric, statistic),
        title => title.into(),
    }
}

/// A statistic by its names in YAML, as in `gates`, in words: `point error p95`.
pub fn key_in_words(metric: &str, statistic: &str) -> String {
    format!("{metric} {statistic}").replace('_', " ")
}

/// The unit of a statistic for people; empty where it is not known.
pub fn unit(metric: &str, statistic: &str) -> &'static str {
    match declared_statistic(metric, statistic).map_or("", |statistic| statistic.unit) {
        "degrees" => "°",
        "index" => "number",
        unit => unit,
    }
}

/// A value with its unit: `12.3 %`, `40°`, `1.4×`; counts and numbers of things stand alone.
pub fn with_unit(value: f64, unit: &str) -> String {
    let text = number(value);
    match unit {
        "°" | "degrees" => format!("{text}°"),
        "ratio" => format!("{text}×"),
        "" | "count" | "index" | "number" | "0 or 1" => text,
        unit => format!("{text} {unit}"),
    }
}

/// A size with its unit, rounded no more than it is written: `60 %`.
pub fn limit_with_unit(limit: f64, unit: &str) -> String {
    let text = number(limit);
    let short = match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    with_unit(limit, unit).replacen(&text, short, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_its_unit_and_a_count_none() {
        let all =
            [(12.0, "%"), (40.5, "°"), (1.4, "ratio"), (7.0, "count")].map(|(value, unit)| with_unit(value, unit));
        assert_eq!(all, ["12 %", "40.50°", "1.400×", "7"]);
        assert_eq!(
            [(0.05, "%"), (60.0, "%"), (2.5, "ratio")].map(|(l, unit)| limit_with_unit(l, unit)),
            ["0.05 %", "60 %", "2.5×"]
        );
    }
}
