//! Surfaces of revolution whose profile is a whole curve that meets its axis, or an unbounded curve, as files state
//! them.

use crate::body::integral;
use crate::ladder::Ladder;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};
use trimtess::import::step::{StepOptions, read};
use trimtess::model::{Model, Severity, Surface};

/// A data section that grows by one instance at a time.
#[derive(Default)]
struct Text {
    lines: String,
    count: u32,
}

type Id = u32;
type Place = [f64; 3];

impl Text {
    fn add(&mut self, instance: &str) -> Id {
        self.count += 1;
        self.lines += &format!("#{}={instance};\n", self.count);
        self.count
    }

    fn triple(&mut self, keyword: &str, [x, y, z]: Place) -> Id {
        self.add(&format!("{keyword}('',({x:?},{y:?},{z:?}))"))
    }

    fn vertex(&mut self, at: Place) -> Id {
        let point = self.triple("CARTESIAN_POINT", at);
        self.add(&format!("VERTEX_POINT('',#{point})"))
    }

    fn frame(&mut self, origin: Place, axis: Place, reference: Place) -> Id {
        let origin = self.triple("CARTESIAN_POINT", origin);
        let [axis, reference] = [axis, reference].map(|d| self.triple("DIRECTION", d));
        self.add(&format!("AXIS2_PLACEMENT_3D('',#{origin},#{axis},#{reference})"))
    }

    fn line(&mut self, from: Place, to: Place) -> Id {
        let point = self.triple("CARTESIAN_POINT", from);
        let along = self.triple("DIRECTION", [0, 1, 2].map(|i| to[i] - from[i]));
        let vector = self.add(&format!("VECTOR('',#{along},1.)"));
        self.add(&format!("LINE('',#{point},#{vector})"))
    }

    /// A conic in the plane y = 0 whose parameter turns from x to z, about `centre`.
    fn conic(&mut self, keyword: &str, centre: Place, sizes: &str) -> Id {
        let frame = self.frame(centre, [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]);
        self.add(&format!("{keyword}('',#{frame},{sizes})"))
    }

    fn edge(&mut self, from: Id, to: Id, curve: Id) -> Id {
        self.add(&format!("EDGE_CURVE('',#{from},#{to},#{curve},.T.)"))
    }

    /// The circle about the z axis at `height` with its vertex above the x axis.
    fn ring(&mut self, radius: f64, height: f64) -> (Id, Id) {
        let frame = self.frame([0.0, 0.0, height], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        let circle = self.add(&format!("CIRCLE('',#{frame},{radius:?})"));
        let vertex = self.vertex([radius, 0.0, height]);
        (vertex, self.edge(vertex, vertex, circle))
    }

    fn bound(&mut self, uses: &[(Id, bool)]) -> Id {
        let uses = uses.iter().map(|&(edge, along)| {
            let sense = if along { 'T' } else { 'F' };
            self.add(&format!("ORIENTED_EDGE('',*,*,#{edge},.{sense}.)"))
        });
        let uses = uses.map(|id| format!("#{id}")).collect::<Vec<_>>().join(",");
        let ring = self.add(&format!("EDGE_LOOP('',({uses}))"));
        self.add(&format!("FACE_BOUND('',#{ring},.T.)"))
    }

    fn face(&mut self, bounds: &[Id], surface: Id) -> Id {
        let bounds = bounds.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",");
        self.add(&format!("ADVANCED_FACE('',({bounds}),#{surface},.T.)"))
    }

    /// The surface of `profile` turned about the z axis.
    fn turned_surface(&mut self, profile: Id) -> Id {
        let origin = self.triple("CARTESIAN_POINT", [0.0; 3]);
        let axis = self.triple("DIRECTION", [0.0, 0.0, 1.0]);
        let axis = self.add(&format!("AXIS1_PLACEMENT('',#{origin},#{axis})"));
        self.add(&format!("SURFACE_OF_REVOLUTION('',#{profile},#{axis})"))
    }

    /// A face on it.
    fn turned(&mut self, profile: Id, bounds: &[Id]) -> Id {
        let surface = self.turned_surface(profile);
        self.face(bounds, surface)
    }

    /// The horizontal face at `height` that looks up or down.
    fn lid(&mut self, uses: &[(Id, bool)], height: f64, up: bool) -> Id {
        let frame = self.frame([0.0, 0.0, height], [0.0, 0.0, if up { 1.0 } else { -1.0 }], [1.0, 0.0, 0.0]);
        let plane = self.add(&format!("PLANE('',#{frame})"));
        let bound = self.bound(uses);
        self.face(&[bound], plane)
    }

    fn model(mut self, faces: &[Id], closed: bool) -> Model {
        let faces = faces.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",");
        let item = if closed {
            let shell = self.add(&format!("CLOSED_SHELL('',({faces}))"));
            self.add(&format!("MANIFOLD_SOLID_BREP('',#{shell})"))
        } else {
            let shell = self.add(&format!("OPEN_SHELL('',({faces}))"));
            self.add(&format!("SHELL_BASED_SURFACE_MODEL('',(#{shell}))"))
        };
        let length = self.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
        let angle = self.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
        let context = self.add(&format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle}))\
             REPRESENTATION_CONTEXT('',''))"
        ));
        self.add(&format!("SHAPE_REPRESENTATION('',(#{item}),#{context})"));
        let text = format!(
            "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n\
             FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n{}ENDSEC;\nEND-ISO-10303-21;\n",
            self.lines
        );
        read(text.as_bytes(), &StepOptions::default()).expect("a readable file")
    }

    /// Checks a solid of these faces at every tolerance.
    fn assert_climbs(self, faces: &[Id], volume: f64, area: f64) {
        let model = self.model(faces, true);
        let bad: Vec<_> = model.diagnostics.iter().filter(|d| d.severity > Severity::Note).collect();
        assert!(bad.is_empty(), "{bad:?}");
        Ladder::solid(model.parts[0].clone(), volume, area).assert_climbs();
    }
}

const FOOT: Place = [2.0, 0.0, 0.0];

/// The apex of the cone over [`FOOT`], above or below.
fn apex(up: bool) -> Place {
    [0.0, 0.0, if up { 1.5 } else { -1.5 }]
}

#[test]
fn a_turned_line_ends_at_its_apex() {
    for seam in [true, false] {
        let mut text = Text::default();
        let (foot, ring) = text.ring(2.0, 0.0);
        let tip = text.vertex(apex(true));
        let profile = text.line(FOOT, apex(true));
        let bounds = if seam {
            let line = text.line(FOOT, apex(true));
            let line = text.edge(foot, tip, line);
            vec![text.bound(&[(ring, true), (line, true), (line, false)])]
        } else {
            let point = text.add(&format!("VERTEX_LOOP('',#{tip})"));
            vec![text.bound(&[(ring, true)]), text.add(&format!("FACE_BOUND('',#{point},.T.)"))]
        };
        let faces = [text.turned(profile, &bounds), text.lid(&[(ring, false)], 0.0, false)];
        text.assert_climbs(&faces, TAU, 9.0 * PI);
    }
}

#[test]
fn two_turned_lines_on_one_ring() {
    let mut text = Text::default();
    let (foot, ring) = text.ring(2.0, 0.0);
    let faces = [true, false].map(|up| {
        let tip = text.vertex(apex(up));
        let [profile, line] = [0, 1].map(|_| text.line(FOOT, apex(up)));
        let line = text.edge(foot, tip, line);
        let bound = text.bound(&[(ring, up), (line, true), (line, false)]);
        text.turned(profile, &[bound])
    });
    text.assert_climbs(&faces, 2.0 * TAU, 10.0 * PI);
}

#[test]
fn a_turned_line_in_two_halves() {
    let mut text = Text::default();
    let (right, left) = (FOOT, [-2.0, 0.0, 0.0]);
    let corners = [right, left].map(|at| text.vertex(at));
    let tip = text.vertex(apex(true));
    let arcs = [0, 1].map(|k| {
        let frame = text.frame([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        let circle = text.add(&format!("CIRCLE('',#{frame},2.)"));
        text.edge(corners[k], corners[1 - k], circle)
    });
    let lines = [0, 1].map(|k| {
        let line = text.line([right, left][k], apex(true));
        text.edge(corners[k], tip, line)
    });
    let mut faces = vec![text.lid(&[(arcs[1], false), (arcs[0], false)], 0.0, false)];
    for k in [0, 1] {
        let profile = text.line(FOOT, apex(true));
        let bound = text.bound(&[(arcs[k], true), (lines[1 - k], true), (lines[k], false)]);
        faces.push(text.turned(profile, &[bound]));
    }
    text.assert_climbs(&faces, TAU, 9.0 * PI);
}

#[test]
fn half_of_a_round_turned_about_its_own_axis() {
    let flat = 0.75f64.sqrt();
    let oblate = 2.0 * TAU * (1.0 + 0.25 / flat * flat.atanh());
    for (keyword, sizes, height, volume, area) in
        [("CIRCLE", "2.", 2.0, 16.0 * FRAC_PI_3, 8.0 * PI), ("ELLIPSE", "2.,1.", 1.0, 8.0 * FRAC_PI_3, oblate)]
    {
        for seam in [true, false] {
            let mut text = Text::default();
            let (foot, ring) = text.ring(2.0, 0.0);
            let [profile, side] = [0, 1].map(|_| text.conic(keyword, [0.0; 3], sizes));
            let pole = text.vertex([0.0, 0.0, height]);
            let side = text.edge(foot, pole, side);
            let bound = if seam {
                text.bound(&[(ring, true), (side, true), (side, false)])
            } else {
                text.bound(&[(ring, true)])
            };
            let faces = [text.turned(profile, &[bound]), text.lid(&[(ring, false)], 0.0, false)];
            text.assert_climbs(&faces, volume, area + 4.0 * PI);
        }
    }
}

/// A circle of radius 2 about (`x`, 0, 0), turned about z. The face lies between its crossings of the axis; its seam is
/// used in both directions.
fn spindle(x: f64) -> (Text, [Id; 1]) {
    let mut text = Text::default();
    let [profile, side] = [0, 1].map(|_| text.conic("CIRCLE", [x, 0.0, 0.0], "2."));
    let height = (4.0 - x * x).sqrt();
    let [low, high] = [-height, height].map(|z| text.vertex([0.0, 0.0, z]));
    let side = text.edge(low, high, side);
    let bound = text.bound(&[(side, true), (side, false)]);
    let face = text.turned(profile, &[bound]);
    (text, [face])
}

#[test]
fn a_whole_circle_about_its_diameter_is_one_sphere() {
    let (text, faces) = spindle(0.0);
    text.assert_climbs(&faces, 32.0 * FRAC_PI_3, 16.0 * PI);
}

#[test]
fn a_circle_across_the_axis_is_the_sheet_on_which_its_seam_lies() {
    let root = 3.0f64.sqrt();
    let (text, faces) = spindle(-1.0);
    text.assert_climbs(&faces, PI * (6.0 * root - 8.0 * FRAC_PI_3), TAU * (4.0 * root - 4.0 * FRAC_PI_3));
    // The apple: swept by the greater part of the circle.
    let (text, faces) = spindle(1.0);
    text.assert_climbs(&faces, PI * (6.0 * root + 16.0 * FRAC_PI_3), TAU * (4.0 * root + 8.0 * FRAC_PI_3));
}

/// A quarter of a bent rod of radius 2 that is thicker than the radius of its bend: the side, on a surface that
/// `surface` adds, and both ends go through the axis.
fn assert_bent_rod_climbs(bend: f64, surface: impl FnOnce(&mut Text) -> Id) {
    let mut text = Text::default();
    let [from, to] = [[2.0 + bend, 0.0, 0.0], [0.0, 2.0 + bend, 0.0]].map(|at| text.vertex(at));
    let about = text.frame([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let circle = text.add(&format!("CIRCLE('',#{about},{:?})", 2.0 + bend));
    let seam = text.edge(from, to, circle);
    let ends = [([bend, 0.0, 0.0], [0.0, -1.0, 0.0], from), ([0.0, bend, 0.0], [1.0, 0.0, 0.0], to)];
    let [start, end] = ends.map(|(centre, axis, vertex)| {
        let frame = text.frame(centre, axis, centre);
        let circle = text.add(&format!("CIRCLE('',#{frame},2.)"));
        text.edge(vertex, vertex, circle)
    });
    let bound = text.bound(&[(seam, true), (end, true), (seam, false), (start, false)]);
    let surface = surface(&mut text);
    let mut faces = vec![text.face(&[bound], surface)];
    for (edge, along, centre, axis) in
        [(start, true, [bend, 0.0, 0.0], [0.0, -1.0, 0.0]), (end, false, [0.0, bend, 0.0], [-1.0, 0.0, 0.0])]
    {
        let frame = text.frame(centre, axis, centre);
        let plane = text.add(&format!("PLANE('',#{frame})"));
        let bound = text.bound(&[(edge, along)]);
        faces.push(text.face(&[bound], plane));
    }
    // Points of the side at `bend + 2 cos t` from the axis. Those beyond it count negative for the volume.
    let beyond = (-0.5 * bend).acos();
    let side = 2.0 * (2.0 * bend * beyond + 4.0 * beyond.sin() - PI * bend) * 2.0;
    text.assert_climbs(&faces, FRAC_PI_2 * bend * 4.0 * PI, FRAC_PI_2 * side + 8.0 * PI);
}

#[test]
fn a_turned_circle_is_kept_on_both_sides_of_the_axis() {
    for bend in [0.9, 1.0, 1.1, 1.8] {
        assert_bent_rod_climbs(bend, |text| {
            let profile = text.conic("CIRCLE", [bend, 0.0, 0.0], "2.");
            text.turned_surface(profile)
        });
    }
}

#[test]
fn a_window_from_one_side_of_the_axis_to_the_other_is_on_both() {
    // The sheets on both sides of the axis are as near to each other as `2 * bend`.
    for bend in [2e-3, 1e-2, 0.1, 0.5f64] {
        let mut text = Text::default();
        let beyond = (-0.5 * bend).acos();
        let (from, to) = (0.3, 0.3 + FRAC_PI_2);
        let (low, high) = (beyond - 0.3, TAU - beyond + 0.2);
        let away = |v: f64| bend + 2.0 * v.cos();
        let radial = |u: f64, r: f64, z: f64| [r * u.cos(), r * u.sin(), z];
        let [[a, b], [d, c]] = [low, high].map(|v| {
            let corner = |u: f64| radial(u, away(v), 2.0 * v.sin());
            [from, to].map(|u| text.vertex(corner(u)))
        });
        let [start, end] = [low, high].map(|v| {
            let frame = text.frame([0.0, 0.0, 2.0 * v.sin()], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
            text.add(&format!("CIRCLE('',#{frame},{:?})", away(v)))
        });
        let [left, right] = [from, to].map(|u: f64| {
            let frame = text.frame(radial(u, bend, 0.0), [u.sin(), -u.cos(), 0.0], radial(u, 1.0, 0.0));
            text.add(&format!("CIRCLE('',#{frame},2.)"))
        });
        let (start, end) = (text.edge(a, b, start), text.edge(d, c, end));
        let (left, right) = (text.edge(a, d, left), text.edge(b, c, right));
        let bound = text.bound(&[(start, true), (right, true), (end, false), (left, false)]);
        let profile = text.conic("CIRCLE", [bend, 0.0, 0.0], "2.");
        let face = text.turned(profile, &[bound]);
        let part = text.model(&[face], false).parts.swap_remove(0);
        let swept = |v: f64| 2.0 * (bend * v + 2.0 * v.sin());
        let inner = swept(beyond) - swept(TAU - beyond);
        let outer = swept(beyond) - swept(low) + swept(high) - swept(TAU - beyond);
        Ladder::sheet(part, FRAC_PI_2 * (inner + outer)).named(bend).assert_climbs();
    }
}

#[test]
fn loops_go_through_the_poles_of_a_torus() {
    for bend in [0.9, 1.0, 1.1, 1.8] {
        assert_bent_rod_climbs(bend, |text| {
            let frame = text.frame([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
            text.add(&format!("TOROIDAL_SURFACE('',#{frame},{bend:?},2.)"))
        });
    }
}

#[test]
fn the_normal_of_an_open_turned_circle_is_that_of_its_start() {
    // The circle's parameter starts at x and goes up or down: the normal points outwards or inwards.
    for (axis, inwards) in [(-1.0, false), (1.0, true)] {
        let mut text = Text::default();
        let (_, ring) = text.ring(2.0, 0.0);
        let frame = text.frame([0.0; 3], [0.0, axis, 0.0], [1.0, 0.0, 0.0]);
        let profile = text.add(&format!("CIRCLE('',#{frame},2.)"));
        let bound = text.bound(&[(ring, !inwards)]);
        let face = text.turned(profile, &[bound]);
        let model = text.model(&[face], false);
        let face = &model.parts[0].faces[0];
        assert!(matches!(face.surface, Surface::Sphere { radius, .. } if (radius - 2.0).abs() < 1e-12), "{face:?}");
        assert_eq!(face.reversed, inwards);
        Ladder::sheet(model.parts[0].clone(), 8.0 * PI).assert_climbs();
    }
}

#[test]
fn a_turned_hyperbola_between_two_rings() {
    let mut text = Text::default();
    let (radius, height) = (1.0f64.cosh(), 2.0 * 1.0f64.sinh());
    let [low, high] = [-height, height].map(|z| text.ring(radius, z).1);
    let bounds = [(low, true), (high, false)].map(|ring| text.bound(&[ring]));
    let profile = text.conic("HYPERBOLA", [0.0; 3], "1.,2.");
    let faces = [
        text.turned(profile, &bounds),
        text.lid(&[(low, false)], -height, false),
        text.lid(&[(high, true)], height, true),
    ];
    let (s, root) = (1.0f64.sinh(), 5.0f64.sqrt());
    let side = 2.0 * TAU * (0.5 * s * (5.0 * s * s + 4.0).sqrt() + 2.0 / root * (0.5 * root * s).asinh());
    text.assert_climbs(&faces, 2.0 * TAU * (s + s.powi(3) / 3.0), side + TAU * radius * radius);
}

#[test]
fn a_turned_parabola_ends_at_its_tip() {
    for seam in [true, false] {
        let mut text = Text::default();
        let (mouth, ring) = text.ring(2.0, 1.0);
        let tip = text.vertex([0.0; 3]);
        let [profile, side] = [0, 1].map(|_| {
            let frame = text.frame([0.0; 3], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]);
            text.add(&format!("PARABOLA('',#{frame},1.)"))
        });
        let side = text.edge(tip, mouth, side);
        let bound =
            if seam { text.bound(&[(ring, false), (side, false), (side, true)]) } else { text.bound(&[(ring, false)]) };
        let faces = [text.turned(profile, &[bound]), text.lid(&[(ring, true)], 1.0, true)];
        text.assert_climbs(&faces, TAU, FRAC_PI_3 * (8.0f64.powf(1.5) - 8.0) + 4.0 * PI);
    }
}

#[test]
fn an_offset_of_a_turned_hyperbola_between_two_rings() {
    // The hyperbola has no ends: the rings give them, half a millimetre off it.
    let mut text = Text::default();
    let at = |t: f64| {
        let (sinh, cosh) = (t.sinh(), t.cosh());
        let by = 0.5 / (sinh * sinh + 4.0 * cosh * cosh).sqrt();
        [cosh + by * 2.0 * cosh, 2.0 * sinh - by * sinh]
    };
    let slope = |t: f64| [0, 1].map(|k| (at(t + 1e-5)[k] - at(t - 1e-5)[k]) / 2e-5);
    let [radius, height] = at(1.0);
    let [low, high] = [-height, height].map(|z| text.ring(radius, z).1);
    let bounds = [(low, true), (high, false)].map(|ring| text.bound(&[ring]));
    let profile = text.conic("HYPERBOLA", [0.0; 3], "1.,2.");
    let basis = text.turned_surface(profile);
    let surface = text.add(&format!("OFFSET_SURFACE('',#{basis},0.5,.F.)"));
    let faces = [
        text.face(&bounds, surface),
        text.lid(&[(low, false)], -height, false),
        text.lid(&[(high, true)], height, true),
    ];
    let side = integral(|t| TAU * at(t)[0] * slope(t)[0].hypot(slope(t)[1]), (-1.0, 1.0));
    let volume = integral(|t| PI * at(t)[0].powi(2) * slope(t)[1], (-1.0, 1.0));
    text.assert_climbs(&faces, volume, side + TAU * radius * radius);
}
