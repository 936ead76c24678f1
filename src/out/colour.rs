//! sRGB colours of files to the linear light of glTF materials and shaders, by the transfer function of IEC 61966-2-1.

use crate::model::Colour;

/// Colour of faces without one: a light grey that leaves room for highlights.
pub(super) const DEFAULT: Colour = [0.76, 0.78, 0.81, 1.0];

/// Converts red, green and blue from sRGB to linear and keeps alpha. Values are clamped to 0..1; non-finite values
/// become 1.
pub(super) fn linear(colour: Colour) -> Colour {
    let [r, g, b, alpha] = colour.map(|value| if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 });
    let decode = |value: f32| if value <= 0.04045 { value / 12.92 } else { libm::powf((value + 0.055) / 1.055, 2.4) };
    [decode(r), decode(g), decode(b), alpha]
}

/// The inverse of [`linear`].
#[cfg(feature = "wgpu")]
pub(super) fn srgb(colour: Colour) -> Colour {
    let [r, g, b, alpha] = colour.map(|value| value.clamp(0.0, 1.0));
    let encode =
        |value: f32| if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * libm::powf(value, 1.0 / 2.4) - 0.055 };
    [encode(r), encode(g), encode(b), alpha]
}
