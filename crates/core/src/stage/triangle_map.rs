use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::TransferPair;
use crate::{Error, Figures, Result, mesh::SurfacePoint, spatial::Nearest};

/// The triangle correspondence: where on the source each part of the target takes its motion from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TriangleMap {
    /// #F of the source.
    #[serde(rename = "source_triangles")]
    pub source_triangle_count: usize,
    /// For each target triangle (#F of the target) the source triangle that it moves like, its partner; `None` for an orphan.
    #[serde(rename = "partners")]
    pub triangles: Vec<Option<u32>>,
    /// For each target vertex (#V of the target) the point of the source that it lies at, `None` where there is none.
    ///
    /// Empty if triangles correspond as wholes, as on meshes of one topology.
    pub points: Vec<Option<SurfacePoint>>,
    /// The report of the correspondence.
    #[serde(skip)]
    pub figures: Figures,
}

impl TriangleMap {
    /// Checks that the map belongs to the surfaces of `pair`.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`], or [`Error::Data`] if a partner does not exist or there is no partner at all.
    pub fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        let (source, target) = (pair.source, pair.target);
        Error::check_shape(
            "correspondence: triangles of the source",
            source.triangle_count(),
            self.source_triangle_count,
        )?;
        Error::check_shape("correspondence: triangles of the target", target.triangle_count(), self.triangles.len())?;
        if !self.points.is_empty() {
            Error::check_shape("correspondence: vertices of the target", target.vertex_count(), self.points.len())?;
        }
        let hint = "make the correspondence again for these meshes";
        if let Some(missing) = self.triangles.iter().flatten().find(|&&p| p as usize >= source.triangle_count()) {
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
        if self.triangles.iter().all(Option::is_none) {
            return Err(Error::data(
                "correspondence: no target triangle has a partner on the source",
                "check that both meshes show the same kind of thing in a similar pose and place, and give more markers where the \
                 method uses them",
            ));
        }
        Ok(())
    }

    /// A source point for every target vertex (#V of the target): the one it lies at; where that is not known, the same corner of
    /// the source triangle that a triangle around it is paired with; where there is none, that of the nearest vertex with one.
    ///
    /// # Errors
    ///
    /// The errors of [`check`](Self::check).
    pub fn source_points(&self, pair: TransferPair<'_>) -> Result<Vec<SurfacePoint>> {
        self.check(pair)?;
        let target = pair.target;
        let mut points = self.points.clone();
        points.resize(target.vertex_count(), None);
        for (corners, partner) in target.triangles.iter().zip(&self.triangles) {
            let Some(partner) = partner else { continue };
            for (&v, &u) in corners.iter().zip(&pair.source.triangles[*partner as usize]) {
                points[v as usize].get_or_insert(SurfacePoint::Vertex(u));
            }
        }
        let known: Vec<(u32, SurfacePoint)> =
            (0..).zip(&points).filter_map(|(v, point)| point.map(|point| (v, point))).collect();
        let places: Vec<_> = known.iter().map(|(v, _)| target.positions[*v as usize]).collect();
        let nearest = Nearest::new(&places)?;
        let point = |(point, place): (&Option<SurfacePoint>, _)| {
            point.unwrap_or_else(|| known[nearest.find(place).0 as usize].1)
        };
        Ok(points.iter().zip(&target.positions).map(point).collect())
    }

    /// Positions of some 2,000 vertices of the target, evenly among all, behind those of their source points.
    ///
    /// # Errors
    ///
    /// The errors of [`check`](Self::check).
    pub fn sample(&self, pair: TransferPair<'_>) -> Result<[Vec<Point3<f64>>; 2]> {
        const MAX_POINTS: usize = 2000;
        let step = pair.target.vertex_count().div_ceil(MAX_POINTS).max(1);
        let points = self.source_points(pair)?;
        let source = points.iter().step_by(step).map(|point| point.position(pair.source, &pair.source.positions));
        Ok([source.collect(), pair.target.positions.iter().step_by(step).copied().collect()])
    }

    /// Number of target triangles without a partner.
    pub fn orphan_count(&self) -> usize {
        self.triangles.iter().filter(|p| p.is_none()).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::meshes;

    #[test]
    fn every_target_vertex_gets_a_source_point_where_one_triangle_has_a_partner() {
        let surface = meshes::icosphere(1);
        let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: None };
        let mut map = TriangleMap { triangles: vec![None; 80], source_triangle_count: 80, ..TriangleMap::default() };
        assert!(map.source_points(pair).is_err(), "no partner at all");
        map.triangles[3] = Some(3);
        let points = map.source_points(pair).unwrap();
        let corners = surface.triangles[3].map(SurfacePoint::Vertex);
        assert!(points.iter().all(|point| corners.contains(point)), "all others take the nearest of three");
        assert!(surface.triangles[3].iter().all(|&v| points[v as usize] == SurfacePoint::Vertex(v)));
        map.points = (0..42).map(|v| Some(SurfacePoint::Vertex(41 - v))).collect();
        assert_eq!(map.source_points(pair).unwrap()[5], SurfacePoint::Vertex(36), "a point that is known goes first");
    }
}
