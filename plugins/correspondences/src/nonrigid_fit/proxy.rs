//! A simplified target that is fitted in place of a large one, which then follows it.
//!
//! The fit is smooth: what a million vertices do is known from fifty thousand. The target is simplified [Garland and Heckbert 1997] and
//! the proxy is fitted. Each vertex p of the target lies, at rest, over a place q of the proxy with barycentric coordinates bᵢ among the
//! corners rᵢ. It goes to
//!
//! x = Σᵢ bᵢ (x̃ᵢ + ½ F̃ᵢ (p − q) + ½ F̃ᵢ (p − rᵢ))
//!
//! with x̃ᵢ the fitted corners and F̃ᵢ their deformation gradients, means of those of the triangles around by area. This is the mean of
//! linear interpolation and of the corners' affine maps, whose errors of second order are opposite [James 2020, Phong deformation]: the
//! target follows without the facets of the proxy.

use mimesh_core::{
    Figures, Result,
    mesh::{Components, Surface, SurfacePoint, simplify_keeping},
    operators::{DeformationGradients, vertex_normals},
    spatial::{ClosestPoint, OnSurface},
    stage::{Link, Marker, ProximityGraph, TransferPair},
};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

use super::unit_frame::UnitFrame;

/// A proxy with more than this part of the target's vertices is not worth its price.
const MAX_SHARE: f64 = 0.7;

/// How much farther than the closest place one that faces the same way may be, in longest edges of the triangle there.
const REACH: f64 = 1.0;

/// A simplified target.
pub struct Proxy {
    /// In the unit frame.
    surface: Surface,
    markers: Vec<Marker>,
    proximity: Option<ProximityGraph>,
    /// Where each vertex of the target lies at rest.
    places: Vec<Place>,
}

/// A place on the proxy: a triangle, and barycentric coordinates of its corners.
#[derive(Clone, Copy)]
struct Place {
    triangle: u32,
    barycentric: [f64; 3],
}

impl Proxy {
    /// A proxy with about `vertices` vertices of the pair's target, which lies in `unit`; `None` where it would have nearly as many
    /// vertices as that.
    ///
    /// Markers keep their places exactly, and every component stays.
    ///
    /// # Errors
    ///
    /// Those of [`simplify_keeping`] and [`ClosestPoint::new`].
    pub fn new(pair: TransferPair<'_>, unit: &UnitFrame, vertices: usize) -> Result<Option<Self>> {
        let target = pair.target;
        let marked: Vec<u32> =
            pair.markers.iter().flat_map(|m| m.target.corners(target)).map(|(vertex, _)| vertex).collect();
        let at_rest = Surface { positions: unit.target.clone(), ..target.clone() };
        let (surface, numbers) = simplify_keeping(&at_rest, vertices, &marked)?;
        drop(at_rest);
        let (of_target, of_proxy) = (target.components(), surface.components());
        let is_smaller = surface.vertex_count() as f64 <= MAX_SHARE * target.vertex_count() as f64;
        if !is_smaller || of_target.count() != of_proxy.count() {
            return Ok(None);
        }
        let mut numbers = numbers.into_iter();
        let markers = pair.markers.iter().filter_map(|marker| {
            let own = marker.target.corners(target).len();
            let corners: Vec<u32> = numbers.by_ref().take(own).collect();
            Some(Marker { target: same_point(&marker.target, &corners, &surface)?, ..marker.clone() })
        });
        let markers: Vec<Marker> = markers.collect();
        if markers.len() < pair.markers.len() {
            return Ok(None);
        }
        let places = Places::new(&surface, &of_proxy)?.all(&unit.target, target, &of_target);
        let proximity = pair.proximity.map(|graph| linked(graph, of_proxy, &surface, &places)).transpose()?;
        Ok(Some(Self { surface, markers, proximity, places }))
    }

    /// Number of its vertices.
    pub fn vertex_count(&self) -> usize {
        self.surface.vertex_count()
    }

    /// The pair with the proxy as its target.
    pub fn pair<'a>(&'a self, pair: TransferPair<'a>) -> TransferPair<'a> {
        let proximity = self.proximity.as_ref();
        TransferPair { target: &self.surface, markers: &self.markers, proximity, ..pair }
    }

    /// The frame of [`pair`](Self::pair).
    pub fn unit(&self, unit: &UnitFrame) -> UnitFrame {
        UnitFrame { source: unit.source.clone(), target: self.surface.positions.clone() }
    }

    /// Where the vertices of the target go, which lie at `rest`, when those of the proxy go to `fit`.
    pub fn carry(&self, rest: &[Point3<f64>], fit: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let gradients = self.vertex_gradients(fit);
        let carry = |(p, place): (&Point3<f64>, &Place)| {
            let corners = self.surface.triangles[place.triangle as usize].map(|v| v as usize);
            let at = corners.iter().zip(place.barycentric);
            let q: Vector3<f64> = at.clone().map(|(&v, b)| self.surface.positions[v].coords * b).sum();
            let moved = at.map(|(&v, b)| {
                let from_corner = (p - self.surface.positions[v]) + (p.coords - q);
                (fit[v].coords + gradients[v] * from_corner * 0.5) * b
            });
            Point3::from(moved.sum::<Vector3<f64>>())
        };
        rest.par_iter().zip(&self.places).map(carry).collect()
    }

    /// How the proxy faces at each vertex of the target when its own vertices are at `fit`.
    pub fn normals(&self, fit: &[Point3<f64>]) -> Vec<Vector3<f64>> {
        let normals = vertex_normals(fit, &self.surface.triangles);
        let normal = |place: &Place| {
            let corners = self.surface.triangles[place.triangle as usize];
            corners.iter().zip(place.barycentric).map(|(&v, b)| normals[v as usize] * b).sum()
        };
        self.places.iter().map(normal).collect()
    }

    /// Deformation gradients at the vertices.
    fn vertex_gradients(&self, fit: &[Point3<f64>]) -> Vec<Matrix3<f64>> {
        let Surface { positions, triangles, .. } = &self.surface;
        let gradients = DeformationGradients::new(positions, triangles);
        let areas = self.surface.area_normals(positions);
        let mut sums = vec![(Matrix3::zeros(), 0.0); positions.len()];
        for (t, corners) in triangles.iter().enumerate().filter(|(t, _)| gradients.is_defined(*t)) {
            let (gradient, area) = (gradients.of_triangle(t, fit), areas[t].norm());
            for &v in corners {
                let (sum, total) = &mut sums[v as usize];
                *sum += gradient * area;
                *total += area;
            }
        }
        sums.into_iter().map(|(sum, total)| if total > 0.0 { sum / total } else { Matrix3::identity() }).collect()
    }
}

/// `point` of the target on the proxy, where its corners have the numbers `corners`.
fn same_point(point: &SurfacePoint, corners: &[u32], proxy: &Surface) -> Option<SurfacePoint> {
    match (*point, corners) {
        (SurfacePoint::Vertex(_), &[vertex]) => Some(SurfacePoint::Vertex(vertex)),
        (SurfacePoint::Triangle(_, barycentric), &[a, b, c]) => {
            // A triangle all of whose corners stay does so, too.
            let triangle = proxy.triangles.iter().position(|t| *t == [a, b, c])?;
            Some(SurfacePoint::Triangle(triangle as u32, barycentric))
        }
        _ => None,
    }
}

/// `graph` between the components of the proxy. Each vertex of a pair stands for the corner nearest to it.
fn linked(
    graph: &ProximityGraph,
    components: Components,
    surface: &Surface,
    places: &[Place],
) -> Result<ProximityGraph> {
    let nearest = |v: u32| {
        let Place { triangle, barycentric } = places[v as usize];
        let most = (0..3).max_by(|&a, &b| barycentric[a].total_cmp(&barycentric[b])).unwrap_or(0);
        surface.triangles[triangle as usize][most]
    };
    let link = |link: &Link| {
        let mut pairs: Vec<[u32; 2]> = Vec::with_capacity(link.pairs.len());
        for pair in link.pairs.iter().map(|pair| pair.map(nearest)) {
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        Link { pairs, ..link.clone() }
    };
    ProximityGraph::new(components, graph.links().map(link).collect(), Figures::default())
}

/// Finds places on a proxy.
struct Places<'a> {
    surface: &'a Surface,
    components: &'a Components,
    search: ClosestPoint,
    normals: Vec<Vector3<f64>>,
}

impl<'a> Places<'a> {
    fn new(surface: &'a Surface, components: &'a Components) -> Result<Self> {
        let search = ClosestPoint::new(&surface.positions, &surface.triangles)?;
        Ok(Self { surface, components, search, normals: surface.area_normals(&surface.positions) })
    }

    /// The places of all vertices of `target`, which lie at `rest`.
    fn all(&self, rest: &[Point3<f64>], target: &Surface, components: &Components) -> Vec<Place> {
        let normals = vertex_normals(rest, &target.triangles);
        let of_vertex = &components.of_vertex;
        (rest, &normals, of_vertex)
            .into_par_iter()
            .map(|(p, normal, component)| self.find(p, normal, *component))
            .collect()
    }

    /// The closest place of the component. One that faces the same way goes first, unless it is much farther: behind a sharp edge no
    /// triangle may do so.
    fn find(&self, p: &Point3<f64>, normal: &Vector3<f64>, component: Option<u32>) -> Place {
        let is_own = |t: u32| self.components.of_vertex[self.surface.triangles[t as usize][0] as usize] == component;
        let closest = self.search.find(p, f64::INFINITY, is_own);
        let closest = closest.expect("each component of the target is one of the proxy, with a triangle");
        let place = |found: OnSurface| Place { triangle: found.triangle, barycentric: found.barycentric };
        if self.faces(closest.triangle, normal) {
            return place(closest);
        }
        let [a, b, c] = self.surface.corners(&self.surface.positions, closest.triangle as usize);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let limit = closest.distance + REACH * longest;
        place(self.search.find(p, limit, |t| is_own(t) && self.faces(t, normal)).unwrap_or(closest))
    }

    fn faces(&self, t: u32, normal: &Vector3<f64>) -> bool {
        self.normals[t as usize].dot(normal) > 0.0
    }
}
