//! Errors: no graphics device, no picture.

use std::fmt;

/// No usable graphics adapter was found.
#[derive(Clone, Debug)]
pub struct NoAdapter {
    /// The adapters found, each with the reason why it was rejected.
    pub found: Vec<String>,
}

impl fmt::Display for NoAdapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no usable graphics adapter")?;
        for refusal in &self.found {
            write!(f, "; {refusal}")?;
        }
        f.write_str(
            ". Install the graphics driver, or a software one: on Debian and Ubuntu `apt install mesa-vulkan-drivers`, \
             on Fedora `dnf install mesa-vulkan-drivers`, on Arch `pacman -S vulkan-swrast`",
        )
    }
}

impl std::error::Error for NoAdapter {}

/// A picture could not be drawn.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The picture is empty, or larger than the adapter allows.
    #[error("cannot draw {} × {} pixels; each side may be 1 to {limit}", .size.0, .size.1)]
    Size {
        /// Requested width and height in pixels.
        size: (u32, u32),
        /// Largest width or height that the adapter allows.
        limit: u32,
    },
    /// The device failed, mostly because it ran out of memory.
    #[error("the graphics device failed: {0}")]
    Device(String),
}
