//! Pictures as PNG files.

use crate::colour::Colour;
use crate::picture::Picture;
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};
use std::collections::BTreeMap;

impl Picture {
    /// The picture as a PNG file, every pixel as it is; with a palette if 256 colours suffice. Empty if the picture is.
    pub fn png(&self) -> Vec<u8> {
        match self.palette() {
            Some(palette) => self.indexed(&palette),
            None => self.encoded(ColorType::Rgb, Filter::Adaptive, None, self.pixels.as_flattened()),
        }
    }

    /// The picture as a PNG file of about half the size: if there are more than 256 colours, near ones are taken for one
    /// until 128 are left (256 in pictures of more than 200,000 pixels), which on shaded surfaces is hardly seen.
    pub fn small_png(&self) -> Vec<u8> {
        match self.palette() {
            Some(palette) => self.indexed(&palette),
            None => {
                let reduced = self.reduced(if self.pixels.len() > 200_000 { 256 } else { 128 });
                reduced.palette().map_or_else(|| self.png(), |palette| reduced.indexed(&palette))
            }
        }
    }

    /// The colours, dark to light; `None` if there are more than 256.
    fn palette(&self) -> Option<Vec<Colour>> {
        let mut colours: Vec<Colour> = Vec::with_capacity(257);
        let mut last = None;
        for pixel in &self.pixels {
            // Runs of one colour are most of a picture.
            if last == Some(*pixel) {
                continue;
            }
            last = Some(*pixel);
            if let Err(place) = colours.binary_search_by_key(&order(*pixel), |colour| order(*colour)) {
                colours.insert(place, *pixel);
                if colours.len() > 256 {
                    return None;
                }
            }
        }
        Some(colours)
    }

    fn indexed(&self, palette: &[Colour]) -> Vec<u8> {
        let mut last = ([0; 3], 0);
        let index_of = |pixel: &Colour| {
            if last.0 != *pixel || *pixel == [0; 3] {
                let place = palette.binary_search_by_key(&order(*pixel), |colour| order(*colour));
                last = (*pixel, place.unwrap_or(0) as u8);
            }
            last.1
        };
        let indices: Vec<u8> = self.pixels.iter().map(index_of).collect();
        self.encoded(ColorType::Indexed, Filter::NoFilter, Some(palette), &indices)
    }

    fn encoded(&self, colours: ColorType, filter: Filter, palette: Option<&[Colour]>, data: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut write = || -> Result<(), EncodingError> {
            let mut encoder = Encoder::new(&mut file, self.width, self.height);
            encoder.set_color(colours);
            encoder.set_depth(BitDepth::Eight);
            encoder.set_compression(Compression::Balanced);
            encoder.set_filter(filter);
            if let Some(palette) = palette {
                encoder.set_palette(palette.as_flattened());
            }
            let mut writer = encoder.write_header()?;
            writer.write_image_data(data)?;
            writer.finish()
        };
        // Writing to memory fails only for a picture without pixels, or whose fields were set at odds.
        if write().is_err() {
            file.clear();
        }
        file
    }

    /// The picture in at most `most` colours, found by median cut: the box of colours that spreads widest, weighted by
    /// its pixels, is cut at its middle until there are enough.
    fn reduced(&self, most: usize) -> Picture {
        let mut counts: BTreeMap<Colour, u32> = BTreeMap::new();
        for pixel in &self.pixels {
            *counts.entry(*pixel).or_default() += 1;
        }
        let mut colours: Vec<(Colour, u32)> = counts.into_iter().collect();
        let mut boxes = vec![Span::new(0, &colours)];
        while boxes.len() < most {
            let widest = (0..boxes.len()).max_by(|a, b| boxes[*a].worth.total_cmp(&boxes[*b].worth).then(b.cmp(a)));
            let Some(widest) = widest.filter(|widest| boxes[*widest].worth > 0.0) else { break };
            let Span { start, len, channel, .. } = boxes[widest];
            let part = &mut colours[start..start + len];
            part.sort_unstable_by_key(|(colour, _)| (colour[channel], *colour));
            let cut = middle(part, channel);
            boxes[widest] = Span::new(start, &part[..cut]);
            boxes.push(Span::new(start + cut, &part[cut..]));
        }
        let mut replaced: Vec<(Colour, Colour)> = Vec::with_capacity(colours.len());
        for Span { start, len, .. } in &boxes {
            let part = &colours[*start..start + len];
            let mean = mean(part);
            replaced.extend(part.iter().map(|(colour, _)| (*colour, mean)));
        }
        replaced.sort_unstable();
        let replace =
            |pixel: &Colour| replaced.binary_search_by_key(pixel, |(from, _)| *from).map_or(*pixel, |i| replaced[i].1);
        Picture { pixels: self.pixels.iter().map(replace).collect(), ..*self }
    }
}

/// Some of the colours of a picture, as a range of a list.
struct Span {
    start: usize,
    len: usize,
    /// The channel in which they spread widest.
    channel: usize,
    /// How much a cut would gain: the sum of squares about the mean in that channel; 0 for one colour.
    worth: f64,
}

impl Span {
    fn new(start: usize, colours: &[(Colour, u32)]) -> Self {
        let total: f64 = colours.iter().map(|(_, count)| f64::from(*count)).sum();
        let spread = |channel: usize| {
            let weighted = |power: i32| -> f64 {
                colours.iter().map(|(c, count)| f64::from(*count) * f64::from(c[channel]).powi(power)).sum()
            };
            (weighted(2) - weighted(1) * weighted(1) / total).max(0.0)
        };
        // The eye sees green best and blue least.
        let spreads = [spread(0) * 2.0, spread(1) * 3.0, spread(2)];
        let channel = if spreads[0] > spreads[1].max(spreads[2]) {
            0
        } else if spreads[1] >= spreads[2] {
            1
        } else {
            2
        };
        let worth = if colours.len() > 1 { spreads[channel].max(f64::MIN_POSITIVE) } else { 0.0 };
        Self { start, len: colours.len(), channel, worth }
    }
}

/// The index of the first colour above the mean in a channel, with at least one on either side.
fn middle(sorted: &[(Colour, u32)], channel: usize) -> usize {
    let mean = f64::from(mean(sorted)[channel]);
    sorted.partition_point(|(colour, _)| f64::from(colour[channel]) <= mean).clamp(1, sorted.len() - 1)
}

/// The mean colour of pixels.
fn mean(colours: &[(Colour, u32)]) -> Colour {
    let total: f64 = colours.iter().map(|(_, count)| f64::from(*count)).sum();
    std::array::from_fn(|channel| {
        let sum: f64 = colours.iter().map(|(c, count)| f64::from(c[channel]) * f64::from(*count)).sum();
        (sum / total).round() as u8
    })
}

/// Colours by brightness, so that neighbours in a shaded surface are neighbours in the palette.
fn order(colour: Colour) -> (u32, Colour) {
    let [r, g, b] = colour.map(u32::from);
    (2 * r + 3 * g + b, colour)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::WHITE;
    use proptest::prelude::*;

    fn decoded(file: &[u8]) -> Picture {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(file));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        assert_eq!(info.color_type, ColorType::Rgb);
        let pixels = data[..info.buffer_size()].chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        Picture { width: info.width, height: info.height, pixels }
    }

    fn gradient(width: u32, height: u32) -> Picture {
        let pixel = |x: u32, y: u32| [(x * 255 / width) as u8, (y * 255 / height) as u8, ((x + y) % 256) as u8];
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect();
        Picture { width, height, pixels }
    }

    #[test]
    fn a_picture_of_many_colours_comes_back_to_the_pixel() {
        let picture = gradient(150, 90);
        assert_eq!(decoded(&picture.png()), picture);
    }

    #[test]
    fn a_small_file_differs_by_little_from_the_picture() {
        let picture = gradient(150, 90);
        let small = decoded(&picture.small_png());
        assert_eq!((small.width, small.height), (150, 90));
        let error = |(a, b): (&Colour, &Colour)| (0..3).map(|c| f64::from(a[c].abs_diff(b[c]))).sum::<f64>() / 3.0;
        let mean = picture.pixels.iter().zip(&small.pixels).map(error).sum::<f64>() / 13_500.0;
        // 128 cells spread over this surface in the colour cube are about 23 wide, a mean distance of 6.
        assert!(mean < 8.0, "{mean}");
    }

    #[test]
    fn a_picture_without_pixels_gives_no_file() {
        assert!(Picture::new(0, 5, WHITE).png().is_empty());
        assert!(Picture { width: 3, height: 3, pixels: vec![] }.small_png().is_empty());
    }

    proptest! {
        #[test]
        fn a_picture_of_few_colours_comes_back_to_the_pixel(
            colours in prop::collection::vec(any::<[u8; 3]>(), 1..256), picks in prop::collection::vec(any::<usize>(), 60)
        ) {
            let pixels = picks.iter().map(|pick| colours[pick % colours.len()]).collect();
            let picture = Picture { width: 10, height: 6, pixels };
            prop_assert_eq!(decoded(&picture.png()), picture.clone());
            prop_assert_eq!(decoded(&picture.small_png()), picture);
        }
    }
}
