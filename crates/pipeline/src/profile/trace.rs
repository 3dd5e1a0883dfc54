//! A trace in the Trace Event format: an object with a list of events, each a line.

use std::{
    io::{self, Write},
    time::Duration,
};

use serde_json::{Value, json};

use super::spans::{Slice, Spans};

/// How a trace of ours begins.
pub(super) const BEGINNING: &str = "{\"otherData\":{\"program\":\"mimesh\"";

/// The process that all events are of.
const PROCESS: u32 = 1;

/// Writes the trace of `spans`.
pub(super) fn write(spans: &Spans, out: &mut dyn Write) -> io::Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    write!(out, "{BEGINNING},\"version\":\"{version}\"}},\"displayTimeUnit\":\"ms\",\"traceEvents\":[")?;
    let name = |kind: &str, thread: u32, name: &str| json!({ "ph": "M", "pid": PROCESS, "tid": thread, "name": kind, "args": { "name": name } });
    write!(out, "\n{}", name("process_name", 0, "mimesh"))?;
    for (&thread, of_thread) in &spans.threads {
        write!(out, ",\n{}", name("thread_name", thread, of_thread))?;
    }
    let mut slices: Vec<&Slice> = spans.slices.iter().collect();
    // Parents before their children; of two that begin and end together, the one that was left last is the parent.
    slices.reverse();
    slices.sort_by_key(|slice| (slice.thread, slice.start, std::cmp::Reverse(slice.whole.wall)));
    for slice in slices {
        write!(out, ",\n{}", event(spans, slice))?;
    }
    writeln!(out, "\n]}}")
}

/// A complete event; `tdur` is CPU time.
fn event(spans: &Spans, slice: &Slice) -> Value {
    let node = &spans.nodes[slice.node];
    let mut event = json!({
        "ph": "X", "pid": PROCESS, "tid": slice.thread, "name": node.label, "cat": node.target,
        "ts": microseconds(slice.start), "dur": microseconds(slice.whole.wall), "tdur": microseconds(slice.whole.cpu),
    });
    if let Some(fields) = &slice.fields {
        event["args"] = Value::Object((**fields).clone());
    }
    event
}

/// To the nanosecond.
fn microseconds(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1e3
}
