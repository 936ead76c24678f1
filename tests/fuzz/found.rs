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
fn a_sheet_with_weights_over_nine_decades_ends() {
    sound(&Sheet {
        net: Net {
            degrees: [1, 1],
            knots: [list([0.0, 1e-9, 1.000000001, 2.000000001]), list([0.0, 0.3, 1.3, 2.3])],
            points: list([
                [7.316e-6, -0.0001266, 4.783e-5],
                [7.597e-5, -0.0001244, 7.822e-5],
                [-5.909e-5, -6.191e-6, -0.000112],
                [-7.316e-6, 5.008e-5, -0.00013],
            ]),
            weights: list([0.05662, 0.0001056, 1.056, 176600.0]),
        },
        loops: list([
            list([
                [0.4916, 0.8694],
                [0.1131, 1.05],
                [-0.0, 2.0],
                [-0.4749, 1.277],
                [-0.4721, 0.8694],
                [-0.3371, 0.5993],
                [-0.06706, 0.4528],
                [0.1808, 0.6215],
            ]),
            list([
                [1.315, -0.4062],
                [0.8708, -0.5312],
                [0.7228, -0.1307],
                [0.7228, -0.1307],
                [0.6492, 0.1638],
                [0.9346, 0.2492],
                [1.311, 0.3988],
                [1.0, -0.0],
            ]),
            list([
                [0.2547, 0.2765],
                [0.2671, 0.4407],
                [0.1475, 0.6038],
                [0.1201, 0.03368],
                [-0.1804, 0.2765],
                [-0.1804, 0.2765],
                [-0.2193, 0.08727],
                [-0.0292, 0.05991],
                [-0.0292, 0.05991],
                [0.1201, 0.03368],
                [0.265, 0.1139],
            ]),
        ]),
        pieces: 0,
        reversed: false,
        sound: false,
        chord_rel: 0.01,
    });
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
