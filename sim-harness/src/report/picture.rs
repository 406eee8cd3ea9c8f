//! A picture in memory, and its PNG encoding.

use std::io::{self, Write};
use std::path::Path;

use crate::output::{self, WriteError};

/// Red, green and blue.
pub type Colour = [u8; 3];

/// Colour around and between drawings.
pub(crate) const PAPER: Colour = [255, 255, 255];

/// Space between pictures side by side, pixels.
const GAP: usize = 8;

/// Pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<Colour>,
}

impl Picture {
    /// A picture of one colour, at least one pixel large.
    #[must_use]
    pub fn new(width: usize, height: usize, colour: Colour) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        Self {
            width,
            height,
            pixels: vec![colour; width * height],
        }
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour at a column, from the left, and a row, from the top; `None` outside.
    #[must_use]
    pub fn pixel(&self, x: usize, y: usize) -> Option<Colour> {
        self.row(y)?.get(x).copied()
    }

    fn row(&self, y: usize) -> Option<&[Colour]> {
        self.pixels.chunks_exact(self.width).nth(y)
    }

    /// One row of pixels to write to; empty outside.
    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [Colour] {
        let row = self.pixels.chunks_exact_mut(self.width).nth(y);
        row.unwrap_or_default()
    }

    /// Fills a rectangle; parts outside the picture are cut.
    pub(crate) fn fill(&mut self, x: usize, y: usize, size: (usize, usize), colour: Colour) {
        for row in y..(y + size.1).min(self.height) {
            self.row_mut(row)
                .iter_mut()
                .skip(x)
                .take(size.0)
                .for_each(|pixel| *pixel = colour);
        }
    }

    /// Mixes a colour into a pixel: 0 leaves the pixel, 255 replaces it.
    pub(crate) fn blend(&mut self, x: usize, y: usize, colour: Colour, coverage: u8) {
        let Some(pixel) = self.row_mut(y).get_mut(x) else {
            return;
        };
        for (old, new) in pixel.iter_mut().zip(colour) {
            let share = u16::from(coverage);
            // At most 255 * 255 + 127, which fits; the quotient is at most 255.
            let mixed = (u16::from(*old) * (255 - share) + u16::from(new) * share + 127) / 255;
            *old = mixed as u8;
        }
    }

    /// Draws another picture over this one; parts outside are cut.
    pub(crate) fn paste(&mut self, x: usize, y: usize, other: &Self) {
        for row in 0..other.height {
            let from = other.row(row).unwrap_or_default();
            let to = self.row_mut(y + row).iter_mut().skip(x);
            to.zip(from).for_each(|(to, from)| *to = *from);
        }
    }

    /// Checksum of the pixels, for tests that pin a picture.
    #[cfg(test)]
    pub(crate) fn checksum(&self) -> u32 {
        amiro_ipf::checksum::CRC.checksum(self.pixels.as_flattened())
    }

    /// Writes the picture as PNG, 8 bit RGB: picture data only, no time, no text.
    ///
    /// # Errors
    /// If the writer fails, or a side has 2^31 pixels or more.
    pub fn write_png(&self, writer: &mut dyn Write) -> io::Result<()> {
        let too_large = |_| io::Error::from(io::ErrorKind::FileTooLarge);
        let width = u32::try_from(self.width).map_err(too_large)?;
        let height = u32::try_from(self.height).map_err(too_large)?;
        let mut encoder = png::Encoder::new(writer, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        // Set explicitly, because defaults may change. A map has at most half the size
        // that `Fast` gives, and no filter has to be tried for each row.
        encoder.set_compression(png::Compression::Balanced);
        encoder.set_filter(png::Filter::Up);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        Ok(writer.finish()?)
    }

    /// Saves the picture as a PNG file, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written; the error names it.
    pub fn save_png(&self, path: &Path) -> Result<(), WriteError> {
        output::write_with(path, |file| self.write_png(file))
    }
}

/// Pictures side by side on common paper, from left to right, aligned at the top.
///
/// As wide as its parts and the gaps between; no picture at all gives one white pixel.
#[must_use]
pub fn beside(pictures: &[Picture]) -> Picture {
    let width: usize = pictures.iter().map(Picture::width).sum();
    let gaps = GAP * pictures.len().saturating_sub(1);
    let height = pictures.iter().map(Picture::height).max().unwrap_or(0);
    let mut sheet = Picture::new(width + gaps, height, PAPER);
    let mut x = 0;
    for picture in pictures {
        sheet.paste(x, 0, picture);
        x += picture.width() + GAP;
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_side_by_side_from_the_top() {
        let sheet = beside(&[Picture::new(3, 2, [1, 2, 3]), Picture::new(2, 5, [4, 5, 6])]);
        assert_eq!((sheet.width(), sheet.height()), (5 + GAP, 5));
        assert_eq!(sheet.pixel(2, 1), Some([1, 2, 3]));
        assert_eq!(sheet.pixel(2, 2), Some(PAPER));
        assert_eq!(sheet.pixel(3, 0), Some(PAPER));
        assert_eq!(sheet.pixel(3 + GAP, 4), Some([4, 5, 6]));
        assert_eq!(sheet.pixel(5 + GAP, 0), None);
        assert_eq!(beside(&[]).pixel(0, 0), Some(PAPER));
    }

    #[test]
    fn png_gives_every_pixel_back() {
        let mut picture = Picture::new(7, 4, [9, 8, 7]);
        picture.fill(5, 2, (10, 10), [255, 0, 1]);
        picture.blend(0, 0, [255, 255, 255], 255);
        let mut bytes = Vec::new();
        picture.write_png(&mut bytes).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((frame.width, frame.height), (7, 4));
        assert_eq!(pixels, picture.pixels.as_flattened());
        assert_eq!(picture.pixel(6, 3), Some([255, 0, 1]));
        assert_eq!(picture.pixel(0, 0), Some([255, 255, 255]));
    }
}
