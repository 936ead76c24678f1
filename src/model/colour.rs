//! Colours of parts, faces and instances.

/// Red, green, blue (sRGB) and opacity, each 0..1.
pub type Colour = [f32; 4];

/// The colour, if a share of it is not from 0 to 1.
pub(crate) fn bad_colour(colour: Option<Colour>) -> Option<Colour> {
    colour.filter(|colour| !colour.iter().all(|share| (0.0..=1.0).contains(share)))
}
