//! What a fit makes of landmarks: forwards and backwards it takes points to where they came from, if the landmarks are right.

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint, simplify},
    operators::voronoi_mass,
    plugin::instance,
    spatial::ClosestPoint,
    stage::{Correspondence, Marker, Proximity, ProximityGraph, TransferPair, TriangleMap},
};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use tracing::{Span, debug_span};

/// A vertex that returns this near to where it started, in diagonals, returns.
const RETURNED: f64 = 0.02;

/// What returns this near to where it started, in diagonals, is the same point.
const AGREED: f64 = 0.005;

/// What lies this near to a landmark, in diagonals, says how good it is.
const AROUND: f64 = 0.1;

/// Two surfaces with fewer triangles, on which fits take little time.
pub struct Proxies<'a> {
    sides: [Side; 2],
    fit: &'a dyn Correspondence,
}

/// A surface with fewer triangles.
pub struct Side {
    /// The surface.
    pub surface: Surface,
    /// The length of the diagonal of its bounding box.
    pub diagonal: f64,
    search: ClosestPoint,
    /// The area that each vertex stands for.
    pub mass: Vec<f64>,
    links: Option<ProximityGraph>,
}

/// How well two fits, of the target to the source and of the source to the target, agree.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The share of the area of source and of target that returns.
    pub returned: [f64; 2],
    /// For each landmark the share of the area around it that returns, on the worse side.
    pub around: Vec<f64>,
    /// For each vertex of the source's proxy how far it comes back from where it started, and where the fit takes it on the target.
    pub source_vertices: Vec<(f64, Option<Point3<f64>>)>,
    /// Places on source and target that both fits take to each other, the closest agreement first.
    pub agreed: Vec<[Point3<f64>; 2]>,
}

impl Comparison {
    /// The share of the area that returns, on the worse side.
    pub fn agreement(&self) -> f64 {
        self.returned[0].min(self.returned[1])
    }
}

impl<'a> Proxies<'a> {
    /// The proxies of the surfaces of `pair`, with about `vertices` vertices each.
    ///
    /// # Errors
    ///
    /// Those of the simplification and of the proximity of components.
    pub fn new(pair: TransferPair<'_>, vertices: usize, fit: &'a dyn Correspondence) -> Result<Self> {
        let sides: Vec<Side> = [pair.source, pair.target]
            .into_par_iter()
            .map(|surface| Side::new(surface, vertices))
            .collect::<Result<_>>()?;
        let sides = sides.try_into().unwrap_or_else(|_| unreachable!("two surfaces, two proxies"));
        Ok(Self { sides, fit })
    }

    /// The proxy of the source.
    pub fn source(&self) -> &Side {
        &self.sides[0]
    }

    /// Compares the two fits that `markers` of `pair` lead to.
    ///
    /// # Errors
    ///
    /// Those of the fit.
    pub fn compare(&self, pair: TransferPair<'_>, markers: &[Marker]) -> Result<Comparison> {
        let [source, target] = &self.sides;
        let on_proxies = |marker: &Marker| Marker {
            name: marker.name.clone(),
            source: source.point(&marker.source.position(pair.source, &pair.source.positions)),
            target: target.point(&marker.target.position(pair.target, &pair.target.positions)),
        };
        let forwards: Vec<Marker> = markers.iter().map(on_proxies).collect();
        let turned = |marker: &Marker| Marker { source: marker.target, target: marker.source, ..marker.clone() };
        let backwards: Vec<Marker> = forwards.iter().map(turned).collect();
        let _fits = debug_span!("fits").entered();
        let span = Span::current();
        let map =
            |from, to, markers: &[Marker]| debug_span!(parent: &span, "fit").in_scope(|| self.map(from, to, markers));
        let (to_source, to_target) = rayon::join(|| map(source, target, &forwards), || map(target, source, &backwards));
        let (to_source, to_target) = (to_source?, to_target?);
        let apart = [returns(source, target, &to_target, &to_source), returns(target, source, &to_source, &to_target)];
        let places = |side: &Side, point: fn(&Marker) -> SurfacePoint| -> Vec<Point3<f64>> {
            forwards.iter().map(|marker| point(marker).position(&side.surface, &side.surface.positions)).collect()
        };
        let (at_source, at_target) = (places(source, |marker| marker.source), places(target, |marker| marker.target));
        let around = (0..markers.len())
            .map(|k| source.share(&apart[0], Some(&at_source[k])).min(target.share(&apart[1], Some(&at_target[k]))));
        let around = around.collect();
        let agreed = agreed(source, target, &to_source, &apart[1]);
        let returned = [source.share(&apart[0], None), target.share(&apart[1], None)];
        let [apart, _] = apart;
        let on_target = |point: &SurfacePoint| point.position(&target.surface, &target.surface.positions);
        let taken = to_target.points.iter().map(|point| point.as_ref().map(on_target));
        Ok(Comparison { returned, around, agreed, source_vertices: apart.into_iter().zip(taken).collect() })
    }

    fn map(&self, source: &Side, target: &Side, markers: &[Marker]) -> Result<TriangleMap> {
        let (source, proximity) = (&source.surface, target.links.as_ref());
        self.fit.correspond(TransferPair { source, target: &target.surface, markers, proximity })
    }
}

impl Side {
    fn new(surface: &Surface, vertices: usize) -> Result<Self> {
        let surface = simplify(surface, vertices)?;
        let proximity = instance::<dyn Proximity>("spanning_tree").filter(|_| surface.components().count() > 1);
        Ok(Self {
            links: proximity.map(|proximity| proximity.proximity(&surface)).transpose()?,
            diagonal: surface.diagonal(),
            search: ClosestPoint::new(&surface.positions, &surface.triangles)?,
            mass: voronoi_mass(&surface.positions, &surface.triangles),
            surface,
        })
    }

    /// The point of the proxy that is nearest to `place`.
    fn point(&self, place: &Point3<f64>) -> SurfacePoint {
        let found = self.search.find(place, f64::INFINITY, |_| true);
        found.map_or(SurfacePoint::Vertex(0), |found| SurfacePoint::Triangle(found.triangle, found.barycentric))
    }

    /// The share of the area, all of it or that around a place, whose vertices return; `apart` has a distance a vertex.
    fn share(&self, apart: &[f64], around: Option<&Point3<f64>>) -> f64 {
        let counts = |p: &Point3<f64>| around.is_none_or(|place| (p - place).norm() <= AROUND * self.diagonal);
        let own = self.surface.positions.iter().zip(&self.mass).zip(apart).filter(|((p, _), _)| counts(p));
        let (all, returned) = own.fold((0.0, 0.0), |(all, returned), ((_, mass), apart)| {
            (all + mass, returned + if *apart <= RETURNED * self.diagonal { *mass } else { 0.0 })
        });
        if all > 0.0 { returned / all } else { 0.0 }
    }
}

/// The places of the vertices of the target that return best, and where the fit takes them on the source.
fn agreed(source: &Side, target: &Side, to_source: &TriangleMap, apart: &[f64]) -> Vec<[Point3<f64>; 2]> {
    let mut order: Vec<usize> = (0..apart.len()).filter(|&v| apart[v] <= AGREED * target.diagonal).collect();
    order.sort_by(|&a, &b| apart[a].total_cmp(&apart[b]).then(a.cmp(&b)));
    let place = |v: usize| {
        let point = to_source.points[v].as_ref()?;
        Some([point.position(&source.surface, &source.surface.positions), target.surface.positions[v]])
    };
    order.into_iter().filter_map(place).collect()
}

/// For each vertex of `from` how far it comes back from where it started, when `there` takes it to `to` and `back` from there; infinite
/// where one of them leads nowhere.
fn returns(from: &Side, to: &Side, there: &TriangleMap, back: &TriangleMap) -> Vec<f64> {
    let places: Vec<Option<Point3<f64>>> = back
        .points
        .iter()
        .map(|point| Some(point.as_ref()?.position(&from.surface, &from.surface.positions)))
        .collect();
    let apart = |(point, place): (&Option<SurfacePoint>, &Point3<f64>)| {
        let corners = point.as_ref()?.corners(&to.surface);
        let mut returned = Vector3::zeros();
        for (corner, share) in corners {
            returned += places.get(corner as usize).copied().flatten()?.coords * share;
        }
        Some((Point3::from(returned) - place).norm())
    };
    there.points.iter().zip(&from.surface.positions).map(|pair| apart(pair).unwrap_or(f64::INFINITY)).collect()
}
