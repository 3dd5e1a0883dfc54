/// The part of a file that is read, and the shapes of it that count as its rest and its poses.
///
/// Formats without such parts read the whole file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Names of nodes, meshes or materials whose polygons are read; all if there is none.
    pub meshes: Vec<String>,
    /// The shape at rest.
    pub rest: RestShape,
    /// The poses.
    pub poses: PoseChoice,
    /// Whether to keep all of the file in [`Mesh::document`](crate::mesh::Mesh::document), for a writer of the same format.
    pub keep_document: bool,
    /// Whether a pose needs the vertices of its rest mesh only, and its polygons do not matter.
    pub same_vertices: bool,
}

/// The shape of a file that counts as its rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RestShape {
    /// As the file stores it: morph targets at 0, nodes and joints where they are without an animation.
    #[default]
    Stored,
    /// The morph target of this name.
    Pose(String),
    /// A clip at a time.
    Clip {
        /// The clip's name.
        name: String,
        /// Seconds from the clip's start.
        seconds: f64,
    },
}

/// The shapes of a file that count as its poses.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PoseChoice {
    /// Every morph target by itself.
    #[default]
    Shapes,
    /// Clips at certain times.
    Clips(ClipChoice),
    /// None.
    Nothing,
}

/// Clips and the times in them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipChoice {
    /// Names of clips; all of the file if there is none.
    pub clips: Vec<String>,
    /// The times.
    pub times: ClipTimes,
    /// The first and the last time in seconds; the whole clip if `None`.
    pub range: Option<[f64; 2]>,
}

/// The times at which a clip is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClipTimes {
    /// So many a second, from the start of the range; its end is one of them if it lies on that raster.
    PerSecond(f64),
    /// Those of its keys.
    Keys,
}

impl Default for ClipTimes {
    fn default() -> Self {
        Self::PerSecond(24.0)
    }
}
