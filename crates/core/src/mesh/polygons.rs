/// Polygons of any number of corners, stored one after another.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Polygons {
    /// Where each polygon starts in `corners`; one entry more than there are polygons once there is any.
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Polygons {
    /// Adds a polygon with these vertices as corners.
    pub fn push(&mut self, corners: &[u32]) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.corners.extend_from_slice(corners);
        self.starts.push(self.corners.len() as u32);
    }

    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there is no polygon.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of corners of all polygons.
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// The vertices of every polygon, one polygon after another.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Where the corners of polygon `polygon` lie in [`corners`](Self::corners).
    pub fn corner_range(&self, polygon: usize) -> std::ops::Range<usize> {
        self.starts[polygon] as usize..self.starts[polygon + 1] as usize
    }

    /// The vertices of polygon `polygon`.
    pub fn get(&self, polygon: usize) -> &[u32] {
        &self.corners[self.corner_range(polygon)]
    }

    /// The polygons in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.len()).map(|polygon| self.get(polygon))
    }

    /// The polygons cut into triangles, each a fan from its first corner, and for each triangle its polygon.
    pub fn fans(&self) -> (Vec<[u32; 3]>, Vec<u32>) {
        let mut triangles = Vec::new();
        let mut polygon_of = Vec::new();
        for (polygon, corners) in self.iter().enumerate() {
            for pair in corners.get(1..).unwrap_or_default().windows(2) {
                triangles.push([corners[0], pair[0], pair[1]]);
                polygon_of.push(polygon as u32);
            }
        }
        (triangles, polygon_of)
    }
}

impl<'a> FromIterator<&'a [u32]> for Polygons {
    fn from_iter<I: IntoIterator<Item = &'a [u32]>>(polygons: I) -> Self {
        let mut result = Self::default();
        polygons.into_iter().for_each(|corners| result.push(corners));
        result
    }
}
