//! A page that looks elsewhere while the result of its last look is being finished gets the result of the new look too.

mod common;
mod socket;

use std::{thread::sleep, time::Duration};

use common::{sample, serve};
use mimesh_core::{
    Result, register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use mimesh_studio::Start;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use socket::{connect, say, wait};

register!(Metric: Slow);

/// A metric that takes its time.
#[derive(Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
struct Slow {}

#[typetag::serde(name = "slow")]
impl Metric for Slow {
    fn bind<'a>(&self, _context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        Ok(Box::new(Self {}))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![]
    }
}

impl BoundMetric for Slow {
    fn measure(&self, _input: MetricInput<'_>) -> Result<Measured> {
        sleep(Duration::from_millis(400));
        Ok(Measured::default())
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_look_that_comes_while_the_last_result_is_measured_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let pipeline = sample(folder.path());
    let text = std::fs::read_to_string(&pipeline).unwrap().replace("edge_stretch", "slow");
    std::fs::write(&pipeline, format!("{text}markers: p.markers.yaml\n")).unwrap();
    let pairs = [0, 3, 5, 7, 9, 11].map(|v| format!("- {{ source: {v}, target: {v} }}\n"));
    std::fs::write(folder.path().join("p.markers.yaml"), format!("markers:\n{}", pairs.concat())).unwrap();
    let client = serve(folder.path(), Some(Start::Pipeline(pipeline)));
    client.wait("/api/pipeline", |pipeline| pipeline["checking"] == false && pipeline["diagnostics"] == json!([]));
    let mut socket = connect(&client).await;
    for number in 1..=4u64 {
        let pose = json!({ "index": number % 2 });
        say(&mut socket, json!({ "type": "look", "look": number, "pose": pose, "channels": ["result"] })).await;
        // The frame is there, and is being measured.
        let is_frame =
            |message: &Value| message["channel"] == "result" && message["look"] == number && message["pose"] == pose;
        wait(&mut socket, is_frame).await;
    }
}
