use serde::{Deserialize, Serialize};

use crate::{Error, Figures, Result};

/// Which source triangle each target triangle takes its motion from.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct TriangleMap {
    /// #F of the source.
    pub source_triangles: usize,
    /// For each target triangle (#F of the target) its partner on the source; `None` for an orphan.
    pub partners: Vec<Option<u32>>,
    /// What the correspondence says of its work.
    #[serde(skip)]
    pub figures: Figures,
}

impl TriangleMap {
    /// Checks that the map belongs to surfaces with these numbers of triangles.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`], or [`Error::Data`] if a partner does not exist or there is no partner at all.
    pub fn check(&self, source_triangles: usize, target_triangles: usize) -> Result<()> {
        Error::check_shape("correspondence: triangles of the source", source_triangles, self.source_triangles)?;
        Error::check_shape("correspondence: triangles of the target", target_triangles, self.partners.len())?;
        let mut none = true;
        for (triangle, partner) in self.partners.iter().enumerate() {
            none &= partner.is_none();
            if partner.is_some_and(|p| p as usize >= source_triangles) {
                return Err(Error::data(
                    format!(
                        "correspondence: target triangle {triangle} has source triangle {} as partner, expected 0 to {}",
                        partner.unwrap_or_default(),
                        source_triangles - 1
                    ),
                    "make the correspondence again for these meshes",
                ));
            }
        }
        if none {
            return Err(Error::data(
                "correspondence: no target triangle has a partner on the source",
                "give more markers, or check that both meshes show the same kind of thing in a similar pose",
            ));
        }
        Ok(())
    }

    /// Number of target triangles without a partner.
    pub fn orphan_count(&self) -> usize {
        self.partners.iter().filter(|p| p.is_none()).count()
    }
}
