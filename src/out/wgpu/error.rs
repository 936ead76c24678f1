//! Why there is no device, or no picture.

use std::fmt;

/// No adapter that can draw.
#[derive(Clone, Debug)]
pub struct NoAdapter {
    /// What was found and why it would not do; empty if nothing was found.
    pub found: Vec<String>,
}

impl fmt::Display for NoAdapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no graphics adapter to draw with")?;
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

/// Why there is no picture.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum RenderError {
    /// The picture has no pixels, or more in a row or column than the adapter allows.
    Size {
        /// What was asked for.
        size: (u32, u32),
        /// The longest side.
        limit: u32,
    },
    /// The device failed, mostly for want of memory.
    Device(String),
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { size, limit } => {
                write!(f, "cannot draw {} × {} pixels; each side may be 1 to {limit}", size.0, size.1)
            }
            Self::Device(cause) => write!(f, "the graphics device failed: {cause}"),
        }
    }
}

impl std::error::Error for RenderError {}
