use std::path::{Path, PathBuf};

use super::{Check, Side, Truth};
use crate::{
    core::{
        plugin,
        stage::{Marker, Metric, Pair},
    },
    mistake::Mistake,
    pipeline::{At, Pipeline, Step, document::path},
    status::Status,
};

impl Check<'_> {
    /// What the stages themselves have to say, and the files among their settings.
    pub(super) fn stages(
        &mut self,
        pipeline: &mut Pipeline,
        source: Option<&Side>,
        target: Option<&Side>,
        markers: Option<&[Marker]>,
    ) {
        if let Some(correspondence) = &mut pipeline.correspondence {
            self.stage_files("correspondence", correspondence.files());
            let needed = correspondence.markers_needed();
            if let Some(markers) = markers.filter(|markers| markers.len() < needed) {
                let has = match markers.len() {
                    0 => "there are none".into(),
                    count => format!("there are {count}"),
                };
                let message = format!("{} needs at least {needed} markers, {has}", correspondence.typetag_name());
                let hint = "a marker is a point of the source and the same point of the target: \
                            `markers: pairs.cons` (a count, then `source, target` vertices from 0)";
                let at = if pipeline.markers.is_some() { path(["markers"]) } else { path(["correspondence"]) };
                self.wrong(&at, At::Value, message, hint);
                return;
            }
        }
        let (Some(source), Some(target), Some(markers)) = (source, target, markers) else { return };
        let graph = match pipeline.proximity.as_ref().map(|proximity| proximity.proximity(&target.surface)) {
            Some(Err(error)) => {
                let name = pipeline.proximity.as_ref().map_or("", |proximity| proximity.typetag_name());
                return self.refused("proximity", name, error);
            }
            Some(Ok(graph)) => Some(graph),
            None => None,
        };
        let pair = Pair { source: &source.surface, target: &target.surface, markers, proximity: graph.as_ref() };
        if let Some(correspondence) = &pipeline.correspondence
            && let Err(error) = correspondence.check(pair)
        {
            self.refused("correspondence", correspondence.typetag_name(), error);
        }
        if let Some(transfer) = &pipeline.transfer
            && let Err(error) = transfer.check(pair)
        {
            self.refused("transfer", transfer.typetag_name(), error);
        }
    }

    /// What is measured: what the pipeline says, else the point error where there is a truth.
    pub(super) fn metrics(&mut self, given: Option<Vec<Box<dyn Metric>>>, truth: &Truth) -> Vec<Box<dyn Metric>> {
        match given {
            Some(metrics) => {
                let wanted = !metrics.is_empty();
                if wanted && matches!(truth, Truth::None) && self.document.value.get("truth").is_none() {
                    let hint = "say where the known results are: `truth: truth/{pose}.obj`; or remove `metrics`";
                    self.wrong(&path(["metrics"]), At::Key, "`metrics` without `truth`", hint);
                }
                metrics
            }
            None => {
                let all = plugin::instances::<dyn Metric>().into_iter();
                all.filter(|(name, _)| *name == "point_error").map(|(_, metric)| metric).collect()
            }
        }
    }

    fn refused(&mut self, stage: &'static str, name: &str, error: crate::core::Error) {
        if self.has_told(&error) {
            return;
        }
        let at = self.document.place(&path([stage]), At::Value);
        let mistake = Mistake::from(error).doing(format!("{stage} ({name})"));
        let status = if mistake.status == Status::Internal { Status::BadData } else { mistake.status };
        self.mistakes.push(Mistake { status, ..mistake.at(at) });
    }

    fn stage_files(&mut self, stage: &'static str, files: Vec<&mut PathBuf>) {
        for file in files {
            let settings = self.document.value.get(stage).and_then(|settings| settings.as_object());
            let said = settings.into_iter().flatten().find(|(_, value)| value.as_str().map(Path::new) == Some(file));
            let at: Vec<_> = path([stage]).into_iter().chain(said.map(|(key, _)| Step::Key(key.clone()))).collect();
            let before = self.mistakes.len();
            self.empty_texts(&at);
            *file = self.path(&at, file);
            if self.mistakes.len() == before {
                self.input(stage, file, &at);
            }
        }
    }
}
