//! Records spans as they are entered and left.

use std::{
    fs::File,
    io::{self, Read, Write},
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use cpu_time::ProcessTime;
use serde_json::{Map, Value};
use tracing::{
    Level, Subscriber,
    field::{Field, Visit as Fields},
    level_filters::LevelFilter,
    span::{Attributes, Id},
    subscriber::Interest,
};
use tracing_subscriber::{
    Layer,
    layer::Context,
    registry::{LookupSpan, SpanRef},
};

use super::{
    frames::{self, Times},
    spans::Spans,
    trace,
    tree::{self, Row},
};

/// Where the time goes, from the moment at which it was made.
#[derive(Clone, Debug)]
pub struct Profile {
    begin: Instant,
    begin_cpu: Duration,
    spans: Arc<Mutex<Spans>>,
}

/// The layer that records for a [`Profile`].
#[derive(Debug)]
pub struct Recorder {
    profile: Profile,
}

/// What is kept with a span while it lives.
struct Recorded {
    node: usize,
    /// The numbers of the span and of its ancestors, the span last.
    path: Box<[u64]>,
    count: u64,
    fields: Option<Box<Map<String, Value>>>,
    /// CPU time of the process when it was entered, for a stage.
    process: Option<Duration>,
}

impl Profile {
    /// Begins; the recorder is to become a layer of the program's subscriber.
    pub fn begin() -> (Self, Recorder) {
        let profile = Self { begin: Instant::now(), begin_cpu: process_time(), spans: Arc::default() };
        (profile.clone(), Recorder { profile })
    }

    /// Where the time went so far, all of it first.
    pub fn rows(&self) -> Vec<Row> {
        let wall = self.begin.elapsed();
        let cpu = process_time().saturating_sub(self.begin_cpu);
        let mut rows = tree::rows(&self.spans());
        rows.iter_mut().for_each(|row| row.depth += 1);
        let waiting = Duration::ZERO;
        rows.insert(0, Row { depth: 0, label: "all".into(), count: 1, wall, cpu, waiting });
        rows
    }

    /// Writes the trace so far.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write_trace(&self, out: &mut dyn Write) -> io::Result<()> {
        trace::write(&self.spans(), out)
    }

    /// Whether the file at `path` is a trace that a profile wrote.
    pub fn is_trace(path: &Path) -> bool {
        let mut beginning = [0; trace::BEGINNING.len()];
        let read = File::open(path).and_then(|mut file| file.read_exact(&mut beginning));
        read.is_ok() && beginning == trace::BEGINNING.as_bytes()
    }

    fn spans(&self) -> MutexGuard<'_, Spans> {
        self.spans.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> Times {
        Times::of_thread(self.begin.elapsed())
    }
}

fn process_time() -> Duration {
    ProcessTime::try_now().map(|time| time.as_duration()).unwrap_or_default()
}

impl<S: Subscriber + for<'s> LookupSpan<'s>> Layer<S> for Recorder {
    fn register_callsite(&self, metadata: &'static tracing::Metadata<'static>) -> Interest {
        if metadata.is_span() && *metadata.level() <= Level::DEBUG { Interest::always() } else { Interest::never() }
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(LevelFilter::DEBUG)
    }

    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let metadata = attributes.metadata();
        let mut found = Found::default();
        attributes.record(&mut found);
        let label = match found.kind {
            Some(kind) if !kind.is_empty() => format!("{} ({kind})", metadata.name()),
            _ => metadata.name().to_owned(),
        };
        let parent = span.parent();
        let of_parent = |parent: &SpanRef<'_, S>| {
            let extensions = parent.extensions();
            extensions.get::<Recorded>().map(|recorded| (recorded.node, recorded.path.clone()))
        };
        let (above, path) = parent.as_ref().and_then(of_parent).unzip();
        let mut path = path.unwrap_or_default().into_vec();
        path.push(id.into_u64());
        let node = self.profile.spans().place(above, label, metadata.target());
        let fields = (!found.others.is_empty()).then(|| Box::new(found.others));
        let process = (*metadata.level() <= Level::INFO).then_some(Duration::ZERO);
        let count = found.count.unwrap_or(1);
        span.extensions_mut().insert(Recorded { node, path: path.into(), count, fields, process });
    }

    fn on_enter(&self, id: &Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let mut extensions = span.extensions_mut();
        if let Some(recorded) = extensions.get_mut::<Recorded>() {
            if let Some(process) = &mut recorded.process {
                *process = process_time();
            }
            frames::enter(&recorded.path, self.profile.now());
        }
    }

    fn on_exit(&self, id: &Id, context: Context<'_, S>) {
        let now = self.profile.now();
        let Some(span) = context.span(id) else { return };
        let mut extensions = span.extensions_mut();
        if let Some(recorded) = extensions.get_mut::<Recorded>()
            && let Some(visit) = frames::leave(&recorded.path, now)
        {
            let mut spans = self.profile.spans();
            // A span that is entered again is the same thing.
            spans.add(recorded.node, visit, std::mem::take(&mut recorded.count), recorded.fields.clone());
            if let Some(before) = recorded.process {
                spans.add_process(recorded.node, process_time().saturating_sub(before));
            }
        }
    }
}

/// The fields of a span.
#[derive(Default)]
struct Found {
    kind: Option<String>,
    count: Option<u64>,
    others: Map<String, Value>,
}

impl Found {
    fn other(&mut self, field: &Field, value: impl Into<Value>) {
        self.others.insert(field.name().into(), value.into());
    }
}

impl Fields for Found {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        self.record_str(field, &format!("{value:?}"));
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        match field.name() {
            "type" => self.kind = Some(value.into()),
            _ => self.other(field, value),
        }
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        match field.name() {
            "count" => self.count = Some(value),
            _ => self.other(field, value),
        }
    }

    fn record_i64(&mut self, field: &Field, value: i64) {
        match u64::try_from(value) {
            Ok(value) => self.record_u64(field, value),
            Err(_) => self.other(field, value),
        }
    }

    fn record_f64(&mut self, field: &Field, value: f64) {
        self.other(field, value);
    }

    fn record_bool(&mut self, field: &Field, value: bool) {
        self.other(field, value);
    }
}

#[cfg(test)]
mod tests {
    use tracing::{debug_span, info_span, subscriber::with_default, trace_span};
    use tracing_subscriber::{Registry, layer::SubscriberExt};

    use super::*;

    fn recorded(work: impl FnOnce()) -> Profile {
        let (profile, recorder) = Profile::begin();
        with_default(Registry::default().with(recorder), work);
        profile
    }

    fn labels(profile: &Profile) -> Vec<(usize, String, u64)> {
        profile.rows().into_iter().map(|row| (row.depth, row.label, row.count)).collect()
    }

    #[test]
    fn spans_are_counted_in_their_places() {
        let profile = recorded(|| {
            let stage = info_span!("stage", "type" = "kind");
            stage.in_scope(|| {
                (0..3).for_each(|step| debug_span!("step", step).in_scope(|| trace_span!("too fine").in_scope(|| {})));
                debug_span!("poses", count = 4).in_scope(|| {});
            });
            debug_span!("step").in_scope(|| {});
            tracing::info!("no span");
        });
        let expected = [(0, "all", 1), (1, "stage (kind)", 1), (2, "step", 3), (2, "poses", 4), (1, "step", 1)];
        assert_eq!(labels(&profile), expected.map(|(depth, label, count)| (depth, label.to_owned(), count)));
    }

    #[test]
    fn a_trace_has_an_event_a_span_with_its_fields_and_is_known_again() {
        let profile = recorded(|| {
            info_span!("stage", of = "a \"b\"").in_scope(|| debug_span!("part", step = 2).in_scope(|| {}));
        });
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.json");
        assert!(!Profile::is_trace(&path));
        std::fs::write(&path, "{\"otherData\":{}}").unwrap();
        assert!(!Profile::is_trace(&path));
        profile.write_trace(&mut File::create(&path).unwrap()).unwrap();
        assert!(Profile::is_trace(&path));
        let trace: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let events: Vec<&Value> = trace["traceEvents"].as_array().unwrap().iter().filter(|e| e["ph"] == "X").collect();
        assert_eq!(events.len(), 2);
        assert_eq!((&events[0]["name"], &events[0]["args"]["of"]), (&"stage".into(), &"a \"b\"".into()));
        assert_eq!((&events[1]["name"], &events[1]["args"]["step"]), (&"part".into(), &2.into()));
        let time = |event: &Value, key: &str| event[key].as_f64().unwrap();
        assert!(time(events[0], "ts") <= time(events[1], "ts"));
        let end = |event: &Value| time(event, "ts") + time(event, "dur");
        assert!(end(events[1]) <= end(events[0]) + 1e-3);
    }
}
