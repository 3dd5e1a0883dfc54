//! Places spread over a cloud of points so that each has a share of it, larger where the cloud asks for larger shares.

use nalgebra::SVector;

use super::fraction;

/// A point of a cloud: a place, and a direction that counts as a place would.
pub type Site = SVector<f64, 6>;

/// A cloud of points.
#[derive(Debug, Default)]
pub struct Cloud {
    /// The points.
    pub places: Vec<Site>,
    /// The measure that each point stands for: an area or a volume.
    pub weights: Vec<f64>,
    /// The size of a share at each point, up to a common factor.
    pub sizes: Vec<f64>,
}

impl Cloud {
    /// `count` sites in the middle of their shares: each the farthest from those before, in sizes, then moved by Lloyd's rule.
    pub fn sites(&self, count: usize, seed: u64) -> Vec<Site> {
        let count = count.min(self.places.len());
        let mut distance = vec![f64::INFINITY; self.places.len()];
        let mut next = (fraction(seed, 11) * self.places.len() as f64) as usize;
        let mut sites = vec![];
        while sites.len() < count {
            let site = self.places[next];
            for ((d, p), size) in distance.iter_mut().zip(&self.places).zip(&self.sizes) {
                *d = d.min((p - site).norm_squared() / (size * size));
            }
            sites.push(site);
            next = (0..distance.len()).fold(0, |best, i| if distance[i] > distance[best] { i } else { best });
        }
        // Few rounds: shares even out, yet stay irregular.
        for _ in 0..6 {
            let mut sums = vec![(Site::zeros(), 0.0); sites.len()];
            for ((p, weight), size) in self.places.iter().zip(&self.weights).zip(&self.sizes) {
                let sum = &mut sums[nearest(&sites, p)];
                // Counted in units of its size, a place where shares are small does not lose them to larger ones.
                let weight = weight / size.powi(3);
                sum.0 += p * weight;
                sum.1 += weight;
            }
            for (site, (sum, weight)) in sites.iter_mut().zip(sums) {
                if weight > 0.0 {
                    *site = sum / weight;
                }
            }
        }
        sites
    }
}

/// The site nearest to `place`.
pub fn nearest(sites: &[Site], place: &Site) -> usize {
    let nearest = sites.iter().enumerate().map(|(i, site)| ((site - place).norm_squared(), i));
    nearest.fold((f64::INFINITY, 0), |best, next| if next.0 < best.0 { next } else { best }).1
}
