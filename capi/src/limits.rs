//! Numbers of options, where 0 stands for the default.

use crate::status::Failure;
use trimtess::frame::PlanLimits;

/// The variant whose number C states. Fails if no variant has it.
macro_rules! choice {
    ($name:literal, $number:expr, $kind:ident { $($variant:ident => $value:expr),* $(,)? }) => {{
        let number: u32 = $number;
        $(if number == $kind::$variant as u32 { $value } else)* {
            return Err($crate::status::Failure::argument(format!("no {} {number}", $name)));
        }
    }};
}
pub(crate) use choice;

/// Limits of plans: triangles, those of a tile, and bytes.
pub(crate) fn plan_limits(triangles: u64, triangles_per_tile: u64, bytes: u64) -> PlanLimits {
    let mut limits = PlanLimits::DEFAULT;
    set(&mut limits.triangles, triangles);
    set(&mut limits.triangles_per_tile, triangles_per_tile);
    set(&mut limits.bytes, bytes);
    limits
}

/// Replaces a default unless `by` is 0.
pub(crate) fn set(value: &mut u64, by: u64) {
    if by > 0 {
        *value = by;
    }
}

/// A finite number above 0, or nothing if C leaves it at 0.
pub(crate) fn positive(name: &str, value: f64) -> Result<Option<f64>, Failure> {
    if value == 0.0 {
        return Ok(None);
    }
    if value > 0.0 && value.is_finite() {
        return Ok(Some(value));
    }
    let range = if value == f64::INFINITY { "finite and above 0" } else { "0 or more" };
    Err(Failure::argument(format!("{name} is {value}; it must be {range}")))
}

/// A number above 0.
pub(crate) fn above_zero(name: &str, value: f64) -> Result<f64, Failure> {
    positive(name, value)?.ok_or_else(|| Failure::argument(format!("{name} is 0; it must be above")))
}

/// Numbers that are finite.
pub(crate) fn finite<const N: usize>(name: &str, values: [f64; N]) -> Result<[f64; N], Failure> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(values);
    }
    Err(Failure::argument(format!("{name} is {values:?}; its numbers must be finite")))
}
