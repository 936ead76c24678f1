//! Inputs that failed once, shrunk: each is judged in every run.

use crate::draw::list;
use crate::sheet::{Net, Sheet};
use crate::solid::{Shape, Solid};
use crate::watch::sound;

/// Each of thousands of segments of noise crosses all others.
#[test]
fn a_tile_of_noise_ends() {
    sound(&Sheet {
        net: Net {
            degrees: [5, 1],
            knots: [
                list([
                    0.0,
                    1e-9,
                    1e-9,
                    0.300000001,
                    0.600000001,
                    0.6000000019999999,
                    1.6000000019999998,
                    2.600000002,
                    3.600000002,
                    4.600000002,
                    5.600000002,
                    6.600000002,
                ]),
                list([0.0, 0.0, 1.0, 1.0]),
            ],
            points: list([
                [0.0001206, -2.687e-5, 0.0001535],
                [0.0001344, 0.0007604, -0.0001604],
                [0.0007982, 5.718e-7, -0.0001707],
                [0.0007444, 0.0007273, 0.0001673],
                [0.001425, -5.432e-5, -8.577e-7],
                [0.001441, 0.0007868, 8.577e-7],
                [0.002331, 5.203e-5, 7.116e-5],
                [0.002105, 0.000621, 8.319e-5],
                [0.002865, -2.459e-5, 0.0001124],
                [0.002975, 0.0007044, -7.978e-5],
                [0.00374, -0.0001126, 0.0001535],
                [0.003769, 0.0007056, -0.0001844],
            ]),
            weights: list([
                0.003036, 20220.0, 43180.0, 0.1085, 338400.0, 31200.0, 0.03293, 3.67e-6, 0.0002022, 1.056, 0.02652,
                6.844e-5,
            ]),
        },
        loops: list([
            list([
                [1.051, 0.1682],
                [1.047, 0.1993],
                [1.107, 0.07582],
                [1.047, 0.1993],
                [1.047, 0.1993],
                [1.006, 0.2078],
                [0.9812, 0.1682],
                [1.007, 0.1309],
                [1.26, -0.1503],
                [1.007, 0.1309],
                [1.038, 0.1526],
            ]),
            list([
                [0.03755, 1.029],
                [-0.01467, 1.077],
                [-0.06162, 1.067],
                [-0.1506, 1.076],
                [-0.1372, 0.9884],
                [-0.06386, 0.9812],
                [-0.02183, 0.99],
            ]),
            list([[0.5929, 0.1306], [0.0, 0.0], [0.3076, 0.1306], [0.4882, 0.04654]]),
        ]),
        pieces: 2,
        reversed: false,
        sound: false,
        chord_rel: 0.01,
    });
}

#[test]
fn a_whole_b_spline_sphere_is_turned_outwards() {
    let shape = Shape::Sphere { radius: 0.01838103, above: None };
    let (turn, placed) = ([-1.786, 1.294, 2.797], ([-0.4805, 2.747, -0.653], 1.0));
    let at = [0.1117, 0.06848, -0.106];
    sound(&Solid { shape, turn, at, placed, nurbs: true, inverted: true, chord_rel: 0.01 });
}

#[test]
fn a_whole_b_spline_torus_far_out_is_turned_outwards() {
    sound(&Solid {
        shape: Shape::Torus { major: 4.343, minor: 2.9697434 },
        turn: [0.0, 0.0, 0.0],
        at: [33550.0, -6596.0, 50760.0],
        placed: ([0.0, 0.0, 0.0], 1.0),
        nurbs: true,
        inverted: true,
        chord_rel: 0.001,
    });
}

/// The crease at v = 3 is one piece long, of seven.
#[test]
fn a_short_crease_is_kept() {
    let mut points = Vec::new();
    (0..7).for_each(|i| {
        (0..3).for_each(|j| points.push([-2.0 + 10.0 * f64::from(i), -2.0 + 10.0 * f64::from(j), -21.0]))
    });
    points[0] = [1.686, 0.8235, 6.67];
    let knots = [list([0.0, 0.0, 0.0, 0.0, 0.25, 3.25, 6.25, 7.25, 7.25, 7.25, 7.25]), list([0.0, 0.0, 3.0, 4.0, 4.0])];
    let net = Net { degrees: [3, 1], knots, points: points.into_iter().collect(), weights: list([]) };
    sound(&Sheet { net, loops: list([]), pieces: 4, reversed: false, sound: true, chord_rel: 0.01 });
}

/// Newton's steps across a crease between spans of very different speeds run to and fro.
#[test]
fn an_edge_crosses_uneven_creases() {
    let knots = [list([0.0, 0.0, 1.0, 1.0]), list([0.0, 0.0, 1.0, 1.25, 4.25, 5.25, 5.25])];
    let points = list([
        [1.153, -1.027, 0.0],
        [1.608, 10.26, 0.0],
        [0.8235, 18.3, 0.0],
        [0.7294, 30.16, 0.0],
        [0.8863, 41.25, 0.0],
        [8.988, -1.529, 0.0],
        [10.84, 9.992, 0.0],
        [11.48, 19.82, 0.0],
        [8.455, 29.35, 0.0],
        [9.6, 41.25, 0.0],
    ]);
    let net = Net { degrees: [1, 1], knots, points, weights: list([]) };
    let loops = list([list([[0.1329, 0.07788], [0.8007, 0.07788], [0.8007, 0.9144], [0.1329, 0.9144]])]);
    sound(&Sheet { net, loops, pieces: 8, reversed: false, sound: true, chord_rel: 0.01 });
}

#[test]
fn a_torus_of_stated_size_far_out_is_quick() {
    sound(&Solid {
        shape: Shape::Torus { major: 32907.200000000004, minor: 20820.385440000005 },
        turn: [0.1848, -2.452, 2.772],
        at: [-398200.0, -453000.0, -208600.0],
        placed: ([2.033, -2.476, -0.7762], 1.027),
        nurbs: false,
        inverted: true,
        chord_rel: 0.001,
    });
}

#[test]
fn a_wavy_sheet_stays_within_its_outline() {
    sound(&Sheet {
        net: Net {
            degrees: [2, 3],
            knots: [list([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), list([0.0, 0.0, 0.0, 0.0, 0.25, 1.25, 1.25, 1.25, 1.25])],
            points: list([
                [0.01387, -0.0002809, -3.917e-5],
                [0.03681, 0.003525, 0.0001811],
                [0.04421, 0.007337, -2.144e-5],
                [0.04716, 0.01139, -0.0001264],
                [-0.04532, 0.01562, 0.0001309],
                [0.1927, 0.0006357, 0.0001368],
                [0.2238, 0.004406, 0.0001619],
                [0.2253, 0.007171, -3.031e-5],
                [0.2726, 0.01115, -0.0001871],
                [0.1949, 0.01528, -4.656e-5],
                [0.4437, 0.0006063, 8.796e-5],
                [0.4492, 0.004513, -3.77e-5],
                [0.4348, 0.00752, 0.0001176],
                [0.4611, 0.01118, -0.0001826],
                [0.4744, 0.01475, 9.241e-5],
            ]),
            weights: list([
                0.5666, 1.1, 1.936, 1.915, 0.5, 0.8801, 0.798, 1.059, 0.8849, 0.8706, 0.9192, 1.755, 0.7599, 0.7436,
                0.5366,
            ]),
        },
        loops: list([
            list([[0.09482, 0.08212], [0.8784, 0.08212], [0.8784, 0.9313], [0.09482, 0.9313]]),
            list([
                [0.5462, 0.4538],
                [0.5, 0.4257],
                [0.458, 0.458],
                [0.4606, 0.5],
                [0.4733, 0.5267],
                [0.5, 0.5486],
                [0.5331, 0.5331],
                [0.5763, 0.5],
            ]),
            list([
                [0.7461, 0.6613],
                [0.7103, 0.6417],
                [0.6748, 0.6563],
                [0.6264, 0.6732],
                [0.6319, 0.7248],
                [0.6629, 0.7643],
                [0.7061, 0.7344],
                [0.7605, 0.7508],
                [0.7394, 0.7],
            ]),
        ]),
        pieces: 7,
        reversed: false,
        sound: true,
        chord_rel: 0.001,
    });
}
