//! The time of spans, added up by their places in the tree.

use std::time::Duration;

use super::spans::Spans;

/// All spans of one label in one place of the tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// How many ancestors it has.
    pub depth: usize,
    /// E.g. `correspondence (nonrigid_fit)`.
    pub label: String,
    /// How many calls, or poses.
    pub count: u64,
    /// Time on the clock, added up where several threads do the same at a time.
    pub wall: Duration,
    /// CPU time: of all threads for a stage, for its parts of the threads that have spans of it.
    pub cpu: Duration,
    /// The part of `wall` for which its own thread had nothing to do, or waited for others, a disk or a CPU.
    pub waiting: Duration,
}

/// The rows of the tree, parents before their children, which come in the order in which they began.
pub(super) fn rows(spans: &Spans) -> Vec<Row> {
    // CPU time that descendants had on other threads.
    let mut elsewhere = vec![Duration::ZERO; spans.nodes.len()];
    for (place, node) in spans.nodes.iter().enumerate().rev() {
        if let Some(parent) = node.parent {
            let of_place = elsewhere[place] + node.apart.cpu;
            elsewhere[parent] += of_place;
        }
    }
    let mut rows = Vec::with_capacity(spans.nodes.len());
    let mut waiting: Vec<(usize, usize)> = children(spans, None).map(|root| (root, 0)).collect();
    waiting.reverse();
    while let Some((place, depth)) = waiting.pop() {
        let node = &spans.nodes[place];
        rows.push(Row {
            depth,
            label: node.label.clone(),
            count: node.count,
            wall: node.own.wall,
            cpu: node.process.unwrap_or(node.own.cpu + elsewhere[place]),
            waiting: node.own.wall.saturating_sub(node.own.cpu),
        });
        let below: Vec<_> = children(spans, Some(place)).map(|child| (child, depth + 1)).collect();
        waiting.extend(below.into_iter().rev());
    }
    rows
}

fn children(spans: &Spans, parent: Option<usize>) -> impl Iterator<Item = usize> {
    spans.nodes.iter().enumerate().filter(move |(_, node)| node.parent == parent).map(|(place, _)| place)
}

#[cfg(test)]
mod tests {
    use super::{
        super::frames::{Times, Visit},
        *,
    };

    fn visit(thread: u32, wall: u64, cpu: u64, is_within: bool) -> Visit {
        let own = Times { wall: Duration::from_millis(wall), cpu: Duration::from_millis(cpu) };
        Visit { start: Duration::ZERO, whole: own, own, is_within, thread }
    }

    #[test]
    fn a_part_on_another_thread_adds_cpu_time_to_those_above_it() {
        let mut spans = Spans::default();
        let stage = spans.place(None, "stage".into(), "test");
        let part = spans.place(Some(stage), "part".into(), "test");
        let inner = spans.place(Some(part), "inner".into(), "test");
        spans.add(inner, visit(1, 5, 5, true), 1, None);
        spans.add(part, visit(1, 20, 20, false), 1, None);
        spans.add(part, visit(0, 30, 10, true), 4, None);
        spans.add(stage, visit(0, 50, 15, false), 1, None);
        let ms = Duration::from_millis;
        let row = |depth, label: &str, count, wall, cpu, waiting| Row {
            depth,
            label: label.into(),
            count,
            wall: ms(wall),
            cpu: ms(cpu),
            waiting: ms(waiting),
        };
        let expected = [row(0, "stage", 1, 50, 35, 35), row(1, "part", 5, 50, 30, 20), row(2, "inner", 1, 5, 5, 0)];
        assert_eq!(rows(&spans), expected);
        // The clock of the process knows threads without spans too.
        spans.add_process(stage, ms(70));
        assert_eq!(rows(&spans)[0].cpu, ms(70));
    }
}
