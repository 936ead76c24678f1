//! Errors: no graphics device, no picture.

/// No usable graphics adapter was found.
#[derive(Clone, Debug, thiserror::Error)]
#[error(
    "no usable graphics adapter{}. Install the graphics driver, or a software one: on Debian and Ubuntu \
     `apt install mesa-vulkan-drivers`, on Fedora `dnf install mesa-vulkan-drivers`, on Arch `pacman -S vulkan-swrast`",
    .found.iter().flat_map(|refusal| ["; ", refusal.as_str()]).collect::<String>()
)]
pub struct NoAdapter {
    /// The adapters found, each with the reason why it was rejected.
    pub found: Vec<String>,
}

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
