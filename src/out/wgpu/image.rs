//! Pixels to a PNG file.

use super::error::RenderError;
use super::target::Reading;
use crate::mesh::SinkError;
use crate::out::pending::write_whole;
use std::fmt;
use std::io::{self, Write};
use std::path::Path;

/// A picture on its way from the device.
pub struct ImageReading {
    device: ::wgpu::Device,
    size: (u32, u32),
    of: Reading,
}

impl ImageReading {
    /// The picture, if it has arrived; `None` until then. Does not wait. Not to be called again after an answer.
    ///
    /// # Errors
    /// If the device fails.
    pub fn poll(&self) -> Option<Result<Image, RenderError>> {
        let (width, height) = self.size;
        Some(self.of.poll(&self.device)?.map(|pixels| Image { width, height, pixels }))
    }
}

impl fmt::Debug for ImageReading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ImageReading").field("size", &self.size).finish_non_exhaustive()
    }
}

/// A picture in memory.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue (sRGB) and alpha, row by row from the top left: 4 × width × height bytes.
    pub pixels: Vec<u8>,
}

impl Image {
    /// Reads a texture of four bytes per pixel back from the device, after waiting for all submitted work.
    /// The texture needs `COPY_SRC` usage.
    ///
    /// # Errors
    /// If the device fails, or cannot copy the texture.
    pub fn read(
        device: &::wgpu::Device,
        queue: &::wgpu::Queue,
        texture: &::wgpu::Texture,
    ) -> Result<Self, RenderError> {
        let ::wgpu::Extent3d { width, height, .. } = texture.size();
        Ok(Self { width, height, pixels: Reading::begin(device, queue, texture, 4)?.wait(device)? })
    }

    /// Begins to [`read`](Self::read) a texture, without waiting. Browsers let no caller wait.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn begin_read(
        device: &::wgpu::Device,
        queue: &::wgpu::Queue,
        texture: &::wgpu::Texture,
    ) -> Result<ImageReading, RenderError> {
        let ::wgpu::Extent3d { width, height, .. } = texture.size();
        Ok(ImageReading {
            device: device.clone(),
            size: (width, height),
            of: Reading::begin(device, queue, texture, 4)?,
        })
    }

    /// The pixel `x` from the left and `y` from the top. `None` outside of the picture.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        let at = 4 * (y as usize * self.width as usize + x as usize);
        let inside = x < self.width && y < self.height;
        inside.then(|| self.pixels.get(at..at + 4)?.try_into().ok()).flatten()
    }

    /// Writes a PNG file atomically.
    ///
    /// # Errors
    /// If the file cannot be created, written or renamed, or the length of `pixels` does not match `width` and
    /// `height`.
    pub fn write_png(&self, path: &Path) -> Result<(), SinkError> {
        write_whole(path, |file| self.encode(file))
    }

    /// Writes a PNG to `file`.
    ///
    /// # Errors
    /// I/O errors of `file`, or a length of `pixels` that does not match `width` and `height`.
    pub fn encode(&self, file: impl Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        Ok(())
    }
}
