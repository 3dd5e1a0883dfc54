//! The stages of a pipeline, one trait a file, with the data that passes between them.
//!
//! A stage is a plain struct of settings that serde reads; what depends on rest meshes alone is done once, in `bind` or
//! `correspond`, and the result is `Send + Sync` and serves every pose. The contract of a stage stands in its trait's doc
//! comment; `testkit::contracts` (feature `testkit`) holds implementations to it.

mod clusterer;
mod component_ref;
mod correspondence;
mod deformer;
mod file_input;
mod format;
mod generator;
mod handles;
mod key_points;
mod landmarks;
mod mesh_writer;
mod metric;
mod pair;
mod proximity;
mod sampler;
mod selection;
mod statistic;
mod transfer;
mod triangle_map;
mod weights;
mod work;

pub use clusterer::{BoundClusterer, Clusterer, Regions};
pub use component_ref::ComponentRef;
pub use correspondence::Correspondence;
pub use deformer::{BoundDeformer, Deformer, Fit, Skin};
pub use file_input::{BytesInput, FileInput, ReadAt};
pub use format::{Format, ScenePoint, check_pose, check_vertices};
pub use generator::Generator;
pub use handles::{HandlePoints, unreached};
pub use key_points::{ChoiceStep, ChoiceWatch, Chosen, KeyPoints, KeyPointsInput};
pub use landmarks::{Landmarks, Proposal, ProposedPair, Suggestion};
pub use mesh_writer::{MeshWriter, PoseWriter, SequenceFile, SequenceFormat, SequenceWriter, WriteError};
pub use metric::{BoundMetric, Frame, Measured, Metric, MetricContext, MetricInput, Posed};
pub use pair::{Marker, TransferPair};
pub use proximity::{Link, Proximity, ProximityGraph};
pub use sampler::{AvailablePoints, Sampler};
pub use selection::{ClipChoice, ClipTimes, PoseChoice, RestShape, Selection};
pub use statistic::{Aggregate, Limits, Statistic};
pub use transfer::{BindInput, BoundTransfer, KeptTransfer, Motion, Transfer, Transferred};
pub use triangle_map::TriangleMap;
pub use weights::{BoundWeights, HandleWeights, KeptWeights, Weights};
pub use work::{Tally, Work};
