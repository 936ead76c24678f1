//! Attributes of parts and instances in frames of views: visibility, colour, tolerance, priority.

use crate::border::{entry, versioned};
use crate::limits::positive;
use crate::session::{tt_session, with_session};
use crate::status::{Failure, tt_status};
use trimtess::frame::Attributes;
use trimtess::mesh::InstanceKey;
use trimtess::model::PartId;

/// How views draw a part, or an instance. Zeros are the defaults. Attributes of an instance and of its part are
/// combined.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_attributes {
    /// `sizeof(tt_attributes)`.
    pub size: u32,
    /// 1 if no view draws it. An instance is drawn if neither it nor its part is hidden. What is hidden asks for no
    /// tiles.
    pub hidden: u32,
    /// 1 if `colour` is drawn instead of the colours of the model. An instance's overrides its part's.
    pub has_colour: u32,
    /// Red, green, blue (sRGB) and opacity, 0 to 1.
    pub colour: [f32; 4],
    /// 0.
    pub reserved: u32,
    /// Factor on `deviation_px` and `size_px` of all views, not on `angle`: 0.5 is twice as fine; 0 = 1. Those of an
    /// instance and its part are multiplied; products below 1e-6 and above 1e6 count as these. Instances that share a
    /// level of detail are as fine as the strictest of them needs.
    pub tolerance_scale: f64,
    /// Factor on the error by which tiles are ordered while `tt_session_options.budget` defers some; 0 = 1. Those of an
    /// instance and its part are multiplied. Instances that share a level of detail share the largest of those in view.
    pub priority: f64,
}
versioned!(tt_attributes, reserved);

fn attributes(from: &tt_attributes) -> Result<Attributes, Failure> {
    let factor = |name: &str, value: f64| Ok::<_, Failure>(positive(name, value)?.unwrap_or(1.0));
    Ok(Attributes::DEFAULT
        .with_visible(from.hidden == 0)
        .with_colour((from.has_colour != 0).then_some(from.colour))
        .with_tolerance_scale(factor("attributes.tolerance_scale", from.tolerance_scale)?)
        .with_priority(factor("attributes.priority", from.priority)?))
}

fn to_c(of: &Attributes) -> tt_attributes {
    tt_attributes {
        size: 0,
        hidden: (!of.visible).into(),
        has_colour: of.colour.is_some().into(),
        colour: of.colour.unwrap_or_default(),
        reserved: 0,
        tolerance_scale: of.tolerance_scale,
        priority: of.priority,
    }
}

/// Sets how views draw a part of the prepared model, from the next frame on: all its instances, together with their own
/// attributes. Replaces what was set before. `attributes` may be null for the defaults. A frame that was begun goes on
/// without them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_set_part(
    session: tt_session,
    part: u32,
    attributes: *const tt_attributes,
) -> tt_status {
    entry!(c => {
        let attributes = self::attributes(&c.read_or_zeros("attributes", attributes)?)?;
        with_session(session, |session| Ok(session.set_part(PartId(part), &attributes)?))
    })
}

/// As `tt_session_set_part`, of one instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_set_instance(
    session: tt_session,
    key: u64,
    attributes: *const tt_attributes,
) -> tt_status {
    entry!(c => {
        let attributes = self::attributes(&c.read_or_zeros("attributes", attributes)?)?;
        with_session(session, |session| Ok(session.set_instance(InstanceKey::from_bits(key), &attributes)?))
    })
}

/// Tells the attributes that a part of the prepared model has.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_get_part_attributes(
    session: tt_session,
    part: u32,
    attributes: *mut tt_attributes,
) -> tt_status {
    entry!(c => {
        let out = c.out_struct("attributes", attributes)?;
        out.give(&to_c(&with_session(session, |session| Ok(session.part_attributes(PartId(part))?))?));
        Ok(())
    })
}

/// Tells the attributes that an instance has, without those of its part.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_get_instance_attributes(
    session: tt_session,
    key: u64,
    attributes: *mut tt_attributes,
) -> tt_status {
    entry!(c => {
        let out = c.out_struct("attributes", attributes)?;
        let key = InstanceKey::from_bits(key);
        out.give(&to_c(&with_session(session, |session| Ok(session.instance_attributes(key)?))?));
        Ok(())
    })
}
