use serde::{Deserialize, Serialize};

use super::Pair;
use crate::{Error, Figures, Result, mesh::SurfacePoint};

/// Where on the source each part of the target takes its motion from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TriangleMap {
    /// #F of the source.
    pub source_triangles: usize,
    /// For each target triangle (#F of the target) the source triangle that it moves like; `None` for an orphan.
    pub partners: Vec<Option<u32>>,
    /// For each target vertex (#V of the target) the point of the source that it lies at, `None` where there is none.
    ///
    /// Empty if triangles correspond as wholes, as on meshes of one topology.
    pub points: Vec<Option<SurfacePoint>>,
    /// What the correspondence says of its work.
    #[serde(skip)]
    pub figures: Figures,
}

impl TriangleMap {
    /// The map that knows nothing: every target triangle an orphan.
    pub fn unknown(pair: Pair<'_>) -> Self {
        Self {
            source_triangles: pair.source.triangle_count(),
            partners: vec![None; pair.target.triangle_count()],
            ..Self::default()
        }
    }

    /// Checks that the map belongs to the surfaces of `pair`.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`], or [`Error::Data`] if a partner does not exist or there is no partner at all.
    pub fn check(&self, pair: Pair<'_>) -> Result<()> {
        let (source, target) = (pair.source, pair.target);
        Error::check_shape("correspondence: triangles of the source", source.triangle_count(), self.source_triangles)?;
        Error::check_shape("correspondence: triangles of the target", target.triangle_count(), self.partners.len())?;
        if !self.points.is_empty() {
            Error::check_shape("correspondence: vertices of the target", target.vertex_count(), self.points.len())?;
        }
        let hint = "make the correspondence again for these meshes";
        if let Some(missing) = self.partners.iter().flatten().find(|&&p| p as usize >= source.triangle_count()) {
            let last = source.triangle_count() - 1;
            return Err(Error::data(
                format!("correspondence: the source has no triangle {missing}: expected 0 to {last}"),
                hint,
            ));
        }
        let exists = |point: &SurfacePoint| match *point {
            SurfacePoint::Vertex(v) => (v as usize) < source.vertex_count(),
            SurfacePoint::Triangle(t, b) => (t as usize) < source.triangle_count() && b.iter().all(|x| x.is_finite()),
        };
        if let Some(missing) = self.points.iter().flatten().find(|p| !exists(p)) {
            return Err(Error::data(format!("correspondence: the source has no point {missing:?}"), hint));
        }
        if self.partners.iter().all(Option::is_none) {
            return Err(Error::data(
                "correspondence: no target triangle has a partner on the source",
                "check that both meshes show the same kind of thing in a similar pose and place, and give more markers where the \
                 method uses them",
            ));
        }
        Ok(())
    }

    /// Number of target triangles without a partner.
    pub fn orphan_count(&self) -> usize {
        self.partners.iter().filter(|p| p.is_none()).count()
    }
}
