//! Commands that help after a run.

/// The commands of the host that help after a run, as its page names them; `None` where the host has none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HelpCommands {
    /// Reads all poses and reports every mistake.
    pub check_poses: Option<String>,
    /// Draws the landmarks that a stage proposes on both meshes, and writes them to a file.
    pub propose_landmarks: Option<String>,
    /// Names the point whose marker helps most.
    pub suggest_marker: Option<String>,
    /// Lists the types of transfers.
    pub list_transfers: Option<String>,
    /// Runs the pipeline with another type of transfer.
    pub run_other_transfer: Option<String>,
    /// Shows several runs beside each other.
    pub compare: Option<String>,
}
