//! Dimensions -> a disc brake and its parts: solids of turned, swept and extruded curves, after Figures 16 and 17 of
//! Kumar & Manocha 1995 (a brake hub and a brake rotor of Alpha_1, Utah).
//!
//! Sides meet only where intersections have closed forms: planes with cylinders, cones and tori across their axis,
//! coaxial surfaces of revolution, a cone with planes parallel to its axis. Neighbours share their edges, so every part
//! is closed.

mod body;
mod caliper;
mod fasteners;
mod hub;
mod path;
mod rotor;

pub(crate) use hub::hub;
pub(crate) use rotor::rotor;

use fasteners::Thread;
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use trimtess::model::{Colour, Instance, Model, ModelBuilder, Part};

const CAST: Colour = [0.62, 0.63, 0.65, 1.0];
const FORGED: Colour = [0.42, 0.46, 0.52, 1.0];
const CAST_PAINTED: Colour = [0.72, 0.1, 0.08, 1.0];
const STEEL: Colour = [0.8, 0.8, 0.78, 1.0];
const LINING: Colour = [0.16, 0.14, 0.13, 1.0];

/// Number of wheel bolts, and their distance from the axis.
const BOLTS: u32 = 5;
const BOLT_CIRCLE: f64 = 57.0;

/// The brake about z: hub, rotor, caliper, two pads, four pistons, and bolts with nuts and washers.
pub(crate) fn assembly() -> Model {
    const WHEEL: Thread = Thread { radius: 6.0, pitch: 1.75 };
    const SCREW: Thread = Thread { radius: 5.0, pitch: 1.5 };
    /// Heights of the washers.
    const WASHER: [f64; 2] = [2.5, 2.0];
    let mut model = ModelBuilder::new("brake-assembly");
    let mut place = |part: Part, places: &[DAffine3]| {
        let name = part.name.clone();
        let part = model.part(part);
        for (k, &transform) in places.iter().enumerate() {
            let name = if places.len() == 1 { name.clone() } else { format!("{name} {}", k + 1) }.into();
            model.instance(Instance { name, ..Instance::new(part, transform) });
        }
    };
    let at = |x: f64, y: f64, z: f64| DAffine3::from_translation(DVec3::new(x, y, z));
    place(hub(), &[DAffine3::IDENTITY]);
    place(rotor(), &[DAffine3::IDENTITY]);

    // The caliper is at the back, where the standard views show it well.
    let stand = DAffine3::from_rotation_z(FRAC_PI_2);
    // Maps parts at the rotor's lower face to its upper face.
    let other = at(0.0, 0.0, rotor::FACES[3]) * DAffine3::from_rotation_x(PI);
    place(caliper::caliper(), &[stand]);
    place(caliper::pad(), &[stand, stand * other]);
    let [x, y] = caliper::PISTONS;
    let back = -caliper::LINING_DEPTH - caliper::PLATE;
    let pistons = [y, -y].map(|y| at(x, y, back));
    place(
        caliper::piston(),
        &[stand * pistons[0], stand * pistons[1], stand * other * pistons[0], stand * other * pistons[1]],
    );
    let [x, y] = caliper::SCREWS;
    let seat = caliper::OUTER[1] - caliper::SUNK;
    let screws = |height: f64| [y, -y].map(|y| stand * at(x, y, height));
    place(fasteners::bolt("caliper bolt", SCREW, seat - caliper::OUTER[0] + 25.0, 18), &screws(seat + WASHER[1]));
    place(fasteners::washer("caliper washer", 5.3, 8.8, WASHER[1]), &screws(seat));

    let around = |height: f64| {
        let place = |k: u32| {
            let p = DVec2::from_angle(TAU * f64::from(k) / f64::from(BOLTS)) * BOLT_CIRCLE;
            at(p.x, p.y, height)
        };
        (0..BOLTS).map(place).collect::<Vec<_>>()
    };
    let (head, foot) = (rotor::BELL[1], hub::FLANGE[0]);
    place(fasteners::bolt("wheel bolt", WHEEL, head - foot + 20.0, 12), &around(head + WASHER[0]));
    place(fasteners::washer("wheel washer", 6.4, 10.4, WASHER[0]), &[around(head), around(foot - WASHER[0])].concat());
    let turns = 5;
    let height = f64::from(turns + 1) * WHEEL.pitch;
    place(fasteners::nut("wheel nut", WHEEL, turns), &around(foot - WASHER[0] - height));
    model.finish().expect("the brake is stated soundly")
}
