//! The disc brake: its parts are closed and have the volumes computed from their dimensions in closed form.

use crate::volumes::{Section, frustum, integral, ring, rounding};
use crate::{alone, meshed, patches, prepared};
use glam::DVec2;
use std::f64::consts::{FRAC_PI_6, PI, TAU};

#[test]
fn brakes_are_closed_at_every_tolerance() {
    for (name, solids) in [("brake-hub", 1), ("brake-rotor", 1), ("brake-assembly", 33)] {
        let prepared = prepared(name);
        for share in [1e-2, 1e-3, 1e-4] {
            let (_, facts, deviation) = meshed(&prepared, share);
            assert!(facts.total.is_closed(), "{name} at {share}: {}", facts.total);
            assert_eq!(facts.total.negative_components, 0, "{name} at {share}: {}", facts.total);
            assert_eq!(facts.total.components, solids, "{name} at {share}: {}", facts.total);
            let worst = deviation.beyond_gap.worst.max(deviation.edges.worst);
            assert!(worst <= 1.0, "{name} at {share}: {deviation}");
        }
    }
}

#[test]
fn the_assembly_has_more_than_three_thousand_patches() {
    let counts = ["brake-hub", "brake-rotor", "brake-assembly"].map(|name| patches(&prepared(name)));
    assert_eq!(counts, [487, 2548, 4086], "docs/gallery.md tells these");
}

fn rotor() -> f64 {
    // The inboard ring, and the outboard ring with the bell.
    let convex = |corner, outwards, radius| -rounding(corner, outwards, radius);
    let inboard =
        ring(88.0, 150.0, 8.0) + convex(88.0, 1.0, 1.5) + convex(88.0, 1.0, 1.0) + 2.0 * convex(150.0, -1.0, 1.0);
    let bell = ring(71.0, 150.0, 8.0)
        + ring(71.0, 78.0, 24.0)
        + ring(34.0, 78.0, 8.0)
        + convex(71.0, 1.0, 1.0)
        + 2.0 * convex(150.0, -1.0, 1.0)
        + rounding(78.0, 1.0, 6.0)
        + convex(78.0, -1.0, 6.0)
        + 2.0 * convex(34.0, 1.0, 1.0)
        + rounding(71.0, -1.0, 3.0);
    // A vane is a strip along an arc of radius 80 between two points, with round ends.
    let chord = DVec2::new(95.0, 0.0).distance(DVec2::from_angle(0.2) * 143.0);
    let arc = 80.0 * 2.0 * (0.5 * chord / 80.0).asin();
    let vane = Section { area: 5.0 * arc + PI * 2.5 * 2.5, outline: 2.0 * arc + PI * 5.0 };
    let vanes = 36.0 * vane.prism(12.0, 2.0, -2.0);
    let drilled = 2.0 * 36.0 * 3.0 * (PI * 9.0 * 7.0 + frustum(3.0, 4.0, 1.0));
    let bolts = 5.0 * (PI * 6.5 * 6.5 * 7.0 + 2.0 * frustum(6.5, 7.0, 0.5));
    let screws = 2.0 * (PI * 3.2 * 3.2 * 5.2 + frustum(3.2, 6.0, 2.8));
    inboard + bell + vanes - drilled - bolts - screws - 3.0 * 8.0 * window()
}

/// Area of the closed cubic B-spline that is the outline of a window.
fn window() -> f64 {
    let controls = [(-9.0, -6.0), (9.0, -6.0), (14.0, 4.0), (5.0, 9.0), (-5.0, 9.0), (-14.0, 4.0)].map(DVec2::from);
    let piece = |k: usize| {
        let p: [DVec2; 4] = [0, 1, 2, 3].map(|j| controls[(k + j) % 6]);
        move |t: f64| {
            let n = [(1.0 - t).powi(3), 4.0 - 6.0 * t * t + 3.0 * t * t * t, 0.0, t * t * t];
            let n = [n[0], n[1], 1.0 + 3.0 * t + 3.0 * t * t - 3.0 * t * t * t, n[3]];
            let d = [-(1.0 - t).powi(2), -4.0 * t + 3.0 * t * t, 1.0 + 2.0 * t - 3.0 * t * t, t * t];
            let at = (0..4).map(|j| p[j] * (n[j] / 6.0)).sum::<DVec2>();
            let speed = (0..4).map(|j| p[j] * (0.5 * d[j])).sum::<DVec2>();
            0.5 * at.perp_dot(speed)
        }
    };
    (0..6).map(|k| integral(piece(k), (0.0, 1.0))).sum()
}

/// Area of a gear with straight flanks.
fn gear(count: f64, foot: f64, tip: f64, [crest, gap]: [f64; 2]) -> f64 {
    let pitch = TAU / count;
    let flank = 0.5 * (1.0 - crest - gap) * pitch;
    count * (0.5 * pitch * (crest * tip * tip + gap * foot * foot) + tip * foot * flank.sin())
}

fn hub() -> f64 {
    // A shoulder from radius 28 to 33 by a cubic between heights 4 and 14.
    let bernstein = |t: f64| [(1.0 - t).powi(3), 3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t), t.powi(3)];
    let mix = |t: f64, c: [f64; 4]| bernstein(t).iter().zip(c).map(|(b, c)| b * c).sum::<f64>();
    let rise = |t: f64| 3.0 * (5.0 * (1.0 - t).powi(2) + 5.0 * t * t);
    // Degree 6 + 2 at most.
    let shoulder = integral(|t| PI * mix(t, [28.0, 28.0, 33.0, 33.0]).powi(2) * rise(t), (0.0, 1.0));
    let seat = frustum(26.5, 28.0, 1.5) + PI * 28.0 * 28.0 * 14.5 + shoulder + PI * 33.0 * 33.0 * 6.0;
    let teeth = 6.0 * gear(48.0, 37.0, 40.0, [0.25, 0.25]);
    let neck = PI * 33.0 * 33.0 * 14.0 + rounding(33.0, 1.0, 1.0) + rounding(33.0, 1.0, 5.0);
    let pilot = PI * 33.95 * 33.95 * 12.5 + frustum(33.95, 32.45, 1.5);
    let recess = frustum(24.0, 25.0, 1.0) + PI * 24.0 * 24.0 * 7.0 - rounding(24.0, -1.0, 2.0);
    let splines = 70.0 * gear(30.0, 16.5, 18.0, [0.2, 0.35]);
    let holes = 5.0 * (PI * 6.2 * 6.2 * 10.4 + 2.0 * frustum(6.2, 7.0, 0.8));
    seat + teeth + neck + lobes().prism(12.0, 2.0, 2.0) + pilot - recess - splines - holes
}

/// The flange: five arcs of radius 11 about the bolts, and five hollow arcs between them, 42 from the axis at their
/// closest.
fn lobes() -> Section {
    let (bolts, lobe, waist, half): (f64, f64, f64, f64) = (57.0, 11.0, 42.0, 0.2 * PI);
    // Centre of a hollow arc, by bisection: its distance from the bolt is the sum of both radii.
    let miss = |far: f64| (bolts * bolts + far * far - 2.0 * bolts * far * half.cos()).sqrt() - (far - waist + lobe);
    let (mut low, mut high) = (waist, 1000.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if miss(middle) > 0.0 { low = middle } else { high = middle }
    }
    let (far, hollow) = (low, low - waist);
    // Angles of the triangle of axis, bolt and hollow centre.
    let between = hollow + lobe;
    let angle = |opposite: f64, a: f64, b: f64| ((a * a + b * b - opposite * opposite) / (2.0 * a * b)).acos();
    let (at_bolt, at_hollow) = (angle(far, bolts, between), angle(bolts, far, between));
    // A tenth of the flange: the triangle without the hollow's sector, and the bolt's sector beyond the triangle.
    let sector = |radius: f64, angle: f64| 0.5 * radius * radius * angle;
    let triangle = 0.5 * bolts * far * half.sin();
    let area = triangle - sector(hollow, at_hollow) - sector(lobe, at_bolt) + sector(lobe, PI);
    Section { area: 10.0 * area, outline: 10.0 * (hollow * at_hollow + lobe * (PI - at_bolt)) }
}

#[test]
fn hub_and_rotor_have_their_volume() {
    for (name, exact) in [("brake-hub", hub()), ("brake-rotor", rotor())] {
        let (chord, facts, _) = meshed(&prepared(name), 1e-5);
        let (volume, area) = (facts.total.volume, facts.total.area);
        assert!((volume - exact).abs() < chord * area, "{name}: {volume}, exact {exact}, chord {chord}, area {area}");
    }
}

/// Volume of a hexagonal prism with `cut` ends chamfered by 30° cones, which start at 0.95 of half the width across
/// flats.
fn hexagon(flats: f64, height: f64, cut: f64) -> f64 {
    let area = 12.0 * 0.5 * flats * flats * FRAC_PI_6.tan();
    let circle = 0.95 * flats;
    // The integral of the distance from the axis over the hexagon.
    let (secant, tangent) = (1.0 / FRAC_PI_6.cos(), FRAC_PI_6.tan());
    let moment = 12.0 * flats.powi(3) / 3.0 * 0.5 * (secant * tangent + (secant + tangent).ln());
    let beyond = moment - TAU * circle.powi(3) / 3.0 - circle * (area - PI * circle * circle);
    area * height - cut * tangent * beyond
}

/// Volume of `turns` rings of thread from root to crest and back.
fn thread(turns: f64, pitch: f64, crest: f64, root: f64) -> f64 {
    let flank = frustum(crest, root, 0.375 * pitch);
    turns * (2.0 * flank + PI * 0.125 * pitch * crest * crest + PI * 0.125 * pitch * root * root)
}

fn caliper() -> f64 {
    let right = [(188.0, 0.0, 80.0), (180.0, 50.0, 16.0), (150.0, 66.0, 16.0), (97.0, 46.0, 8.0)];
    let left = [(97.0, -46.0, 8.0), (150.0, -66.0, 16.0), (180.0, -50.0, 16.0)];
    let arm = Section::rounded(&[&right[..], &left].concat());
    let bridge = Section::rounded(&[(157.0, 26.0, 6.0), (176.0, 26.0, 6.0), (172.0, 48.0, 6.0), (157.0, 54.0, 6.0)]);
    let arms = arm.prism(32.0 + 30.0, 2.0, 6.0) + arm.prism(0.0, 2.0, 2.0);
    let bore = frustum(20.0, 19.0, 1.0) + PI * 19.0 * 19.0 * 23.0 + ring(19.0, 21.5, 3.0) - rounding(19.0, -1.0, 2.0);
    let screw = PI * 81.0 * 4.0 + PI * 5.25 * 5.25 * 119.0 + frustum(5.25, 6.25, 1.0);
    arms + 2.0 * bridge.prism(62.0, 2.0, -3.0) - 4.0 * bore - 2.0 * screw
}

#[test]
fn the_other_parts_have_their_volume() {
    let washer = ring(6.4, 10.4, 2.5) - 2.0 * rounding(10.4, -1.0, 0.625);
    let nut = {
        let (pitch, radius): (f64, f64) = (1.75, 6.0);
        let (root, mouth) = (radius - 0.6 * pitch, radius + 0.3 * pitch);
        let hole = thread(5.0, pitch, root, radius) + 2.0 * frustum(mouth, root, 0.5 * pitch);
        hexagon(9.0, 6.0 * pitch, 2.0) - hole
    };
    let piston =
        PI * 18.95 * 18.95 * 22.0 - rounding(18.95, -1.0, 2.0) - rounding(18.95, -1.0, 1.0) - PI * 13.0 * 13.0 * 16.0
            + rounding(13.0, -1.0, 3.0)
            - rounding(13.0, 1.0, 0.5)
            - ring(17.45, 18.95, 2.0)
            + 2.0 * rounding(17.45, 1.0, 0.5);
    let pad = {
        let plate = [(98.0, -38.0, 6.0), (140.0, -48.0, 6.0), (140.0, 48.0, 6.0), (98.0, 38.0, 6.0)];
        let block = Section::rounded(&[(102.0, 2.0, 4.0), (136.0, 2.0, 4.0), (136.0, 43.0, 4.0), (102.0, 35.0, 4.0)]);
        // A chamfer of 45°: the integrals of the offset and of its square over its height.
        let chamfer = 0.5 * 1.5 * 1.5 * block.outline - PI * 1.5_f64.powi(3) / 3.0;
        Section::rounded(&plate).prism(6.0, 2.0, 1.0) + 2.0 * (10.0 * block.area - chamfer)
    };
    let model = trimtess_models::by_name("brake-assembly").unwrap();
    for (name, exact) in
        [("wheel washer", washer), ("wheel nut", nut), ("piston", piston), ("pad", pad), ("caliper", caliper())]
    {
        let part = model.parts.iter().find(|part| part.name == name).unwrap();
        let (chord, facts, _) = meshed(&alone(part.clone()), 1e-5);
        let (volume, area) = (facts.total.volume, facts.total.area);
        assert!((volume - exact).abs() < chord * area, "{name}: {volume}, exact {exact}, chord {chord}, area {area}");
    }
}
