//! Pictures as PNG files.

use crate::picture::Picture;
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};

/// Colours of a small file, and of one whose picture has more than [`LARGE_PICTURE`] pixels.
const SMALL_PALETTE: i32 = 128;
const LARGE_PALETTE: i32 = 256;
const LARGE_PICTURE: usize = 200_000;

impl Picture {
    /// Returns the picture as a PNG file with every pixel as it is; an empty file if the picture is empty.
    pub fn png(&self) -> Vec<u8> {
        self.encoded(ColorType::Rgb, Filter::Adaptive, None, self.pixels.as_flattened())
    }

    /// Returns the picture as a PNG file of a third of the size, with at most 128 colours, or 256 if it has more than
    /// 200,000 pixels.
    ///
    /// A picture of fewer colours keeps every pixel. On shaded surfaces the difference is hardly seen.
    pub fn small_png(&self) -> Vec<u8> {
        if self.pixels.is_empty() || self.pixels.len() != self.width as usize * self.height as usize {
            return Vec::new();
        }
        self.indexed().unwrap_or_else(|_| self.png())
    }

    /// The picture with its colours reduced to a palette.
    fn indexed(&self) -> Result<Vec<u8>, quantizr::Error> {
        let rgba: Vec<u8> = self.pixels.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
        let image = quantizr::Image::new(&rgba, self.width as usize, self.height as usize)?;
        let mut options = quantizr::Options::default();
        options.set_max_colors(if self.pixels.len() > LARGE_PICTURE { LARGE_PALETTE } else { SMALL_PALETTE })?;
        let mut quantized = quantizr::QuantizeResult::quantize(&image, &options);
        // Dithering would make noise of even areas, which neither looks better nor compresses.
        quantized.set_dithering_level(0.0)?;
        let mut indices = vec![0; self.pixels.len()];
        quantized.remap_image(&image, &mut indices)?;
        let palette = quantized.get_palette();
        let colours = palette.entries.iter().take(palette.count as usize);
        let colours: Vec<u8> = colours.flat_map(|colour| [colour.r, colour.g, colour.b]).collect();
        Ok(self.encoded(ColorType::Indexed, Filter::NoFilter, Some(&colours), &indices))
    }

    fn encoded(&self, colours: ColorType, filter: Filter, palette: Option<&[u8]>, data: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut write = || -> Result<(), EncodingError> {
            let mut encoder = Encoder::new(&mut file, self.width, self.height);
            encoder.set_color(colours);
            encoder.set_depth(BitDepth::Eight);
            encoder.set_compression(Compression::Balanced);
            encoder.set_filter(filter);
            if let Some(palette) = palette {
                encoder.set_palette(palette);
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Colour, WHITE};
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
        assert_eq!(picture.small_png(), picture.small_png());
    }

    #[test]
    fn a_picture_without_pixels_gives_no_file() {
        assert!(Picture::new(0, 5, WHITE).png().is_empty());
        assert!(Picture::new(0, 5, WHITE).small_png().is_empty());
        for pixels in [vec![], vec![WHITE; 8], vec![WHITE; 10]] {
            assert!(Picture { width: 3, height: 3, pixels }.small_png().is_empty());
        }
    }

    proptest! {
        #[test]
        fn a_picture_of_few_colours_comes_back_to_the_pixel(
            colours in prop::collection::vec(any::<[u8; 3]>(), 1..128), picks in prop::collection::vec(any::<usize>(), 60)
        ) {
            let pixels = picks.iter().map(|pick| colours[pick % colours.len()]).collect();
            let picture = Picture { width: 10, height: 6, pixels };
            prop_assert_eq!(decoded(&picture.png()), picture.clone());
            prop_assert_eq!(decoded(&picture.small_png()), picture);
        }
    }
}
