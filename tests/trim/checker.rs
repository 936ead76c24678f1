//! A tile's triangles -> facts, or what is wrong with them. Independent of how they were made.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use trimtess::frame::internals::trim::{TrimInput, TrimOutput};
use trimtess::math::predicates::orient2d;

/// A tile that owns its loops.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tile {
    pub(crate) cells: (u32, u32),
    pub(crate) points: Vec<DVec2>,
    pub(crate) loop_starts: Vec<u32>,
    pub(crate) places: Vec<DVec3>,
}

impl Tile {
    /// Points with equal coordinates are at one place in space, all others at different places.
    pub(crate) fn new(cells: (u32, u32), loops: &[Vec<DVec2>]) -> Self {
        let mut tile = Self { cells, points: Vec::new(), loop_starts: vec![0], places: Vec::new() };
        for points in loops {
            tile.points.extend_from_slice(points);
            tile.loop_starts.push(tile.points.len() as u32);
        }
        tile.places = tile.points.iter().map(|p| p.extend(0.0)).collect();
        tile
    }

    pub(crate) fn input(&self) -> TrimInput<'_> {
        let Self { cells, points, loop_starts, places } = self;
        TrimInput { cells: *cells, points, loop_starts, places }
    }

    /// The source of a test for `cases.rs`.
    pub(crate) fn as_test(&self) -> String {
        let polygon = |w: &[u32]| {
            let points: Vec<(f64, f64)> =
                self.points[w[0] as usize..w[1] as usize].iter().map(|p| (p.x, p.y)).collect();
            format!("polygon(&{points:?})")
        };
        let loops: Vec<String> = self.loop_starts.windows(2).map(polygon).collect();
        format!("#[test]\nfn NAME() {{\n    assert_exact({:?}, &[{}]);\n}}", self.cells, loops.join(", "))
    }
}

/// Signed area of a polygon, relative to its first point so that small loops far from the origin keep their digits.
pub(crate) fn area(points: &[DVec2]) -> f64 {
    let Some(&origin) = points.first() else { return 0.0 };
    let fan = points.windows(2).map(|w| (w[0] - origin).perp_dot(w[1] - origin));
    0.5 * fan.sum::<f64>()
}

/// All triangles of a tile; full cells are split along the diagonal from (i, j).
pub(crate) fn all_triangles(input: &TrimInput<'_>, out: &TrimOutput) -> Vec<[u32; 3]> {
    let mut all = out.triangles.clone();
    let corner = |i: u32, j: u32| input.points.len() as u32 + j * (input.cells.0 + 1) + i;
    for &[i, j] in &out.full_cells {
        all.push([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)]);
        all.push([corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)]);
    }
    all
}

pub(crate) fn position(input: &TrimInput<'_>, out: &TrimOutput, vertex: u32) -> DVec2 {
    let (vertex, count, width) = (vertex as usize, input.points.len(), input.cells.0 as usize + 1);
    if vertex < count {
        return input.points[vertex];
    }
    let corner = vertex - count;
    let corners = width * (input.cells.1 as usize + 1);
    if corner < corners {
        DVec2::new((corner % width) as f64, (corner / width) as f64)
    } else {
        out.extra_points[corner - corners]
    }
}

/// The smallest angle of each trim triangle, in degrees.
pub(crate) fn min_angles(input: &TrimInput<'_>, out: &TrimOutput) -> Vec<f64> {
    let angle = |p: [DVec2; 3], k: usize| (p[(k + 1) % 3] - p[k]).angle_to(p[(k + 2) % 3] - p[k]).to_degrees();
    let smallest = |t: &[u32; 3]| {
        let p = t.map(|v| position(input, out, v));
        (0..3).map(|k| angle(p, k)).fold(f64::INFINITY, f64::min)
    };
    out.triangles.iter().map(smallest).collect()
}

/// What [`check`] measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facts {
    pub(crate) area: f64,
}

/// Checks that triangles are positive and match along inner edges. With `exact`, also checks the boundary and the area:
/// every tessellant segment of nonzero length that no other cancels is an edge of exactly one triangle, in its
/// direction. Points with equal coordinates count as one vertex.
pub(crate) fn check(input: &TrimInput<'_>, out: &TrimOutput, exact: bool) -> Result<Facts, String> {
    let mut by_position: HashMap<(u64, u64), u32> = HashMap::new();
    let bits = |p: DVec2| ((p.x + 0.0).to_bits(), (p.y + 0.0).to_bits());
    let count = input.points.len() as u32;
    let total = count + (input.cells.0 + 1) * (input.cells.1 + 1) + out.extra_points.len() as u32;
    let mut vertex = |v: u32| *by_position.entry(bits(position(input, out, v))).or_insert(v);
    let mut segments: HashMap<[u32; 2], u32> = HashMap::new();
    for w in input.loop_starts.windows(2) {
        for v in w[0]..w[1] {
            let next = if v + 1 == w[1] { w[0] } else { v + 1 };
            let ends = [vertex(v), vertex(next)];
            if ends[0] != ends[1] {
                *segments.entry(ends).or_default() += 1;
            }
        }
    }
    let all = all_triangles(input, out);
    let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
    let mut facts = Facts { area: 0.0 };
    for triangle in &all {
        if triangle.iter().any(|&v| v >= total) {
            return Err(format!("triangle {triangle:?} names a vertex that does not exist"));
        }
        let p = triangle.map(|v| position(input, out, v));
        let turn = orient2d(p[0], p[1], p[2]);
        if turn <= 0.0 {
            return Err(format!("triangle {triangle:?} at {p:?} has turn {turn}"));
        }
        facts.area += 0.5 * turn;
        for k in 0..3 {
            *edges.entry([vertex(triangle[k]), vertex(triangle[(k + 1) % 3])]).or_default() += 1;
        }
    }
    let reverse = |e: &[u32; 2]| [e[1], e[0]];
    for (edge, &n) in &edges {
        if n > 1 {
            return Err(format!("edge {edge:?} is used {n} times in one direction"));
        }
        let matched = edges.contains_key(&reverse(edge));
        let (forward, backward) = (segments.contains_key(edge), segments.contains_key(&reverse(edge)));
        if !forward && !matched && (exact || !backward) && !on_border_of(input, out, *edge, exact) {
            return Err(format!("edge {edge:?} has no partner"));
        }
        if exact && forward != backward && matched {
            return Err(format!("both sides of the segment {edge:?} are kept"));
        }
    }
    if exact {
        let cancels = |s: &[u32; 2]| segments.get(s) == segments.get(&reverse(s));
        if let Some((segment, n)) = segments.iter().find(|(s, n)| !cancels(s) && (**n != 1 || !edges.contains_key(*s)))
        {
            return Err(format!("segment {segment:?} occurs {n} times and is not a triangle's edge once"));
        }
        let want: f64 = input.loop_starts.windows(2).map(|w| area(&input.points[w[0] as usize..w[1] as usize])).sum();
        let tile = f64::from(input.cells.0) * f64::from(input.cells.1);
        if (want - facts.area).abs() > 1e-12 * tile {
            return Err(format!("area {} instead of {want}", facts.area));
        }
        if !out.extra_points.is_empty() {
            return Err("points were added".into());
        }
    }
    Ok(facts)
}

/// Checks that the boundary of all triangles is the loops, as chains over places in space, and that triangles which
/// only close name three places. Holds for every input.
pub(crate) fn check_boundary(input: &TrimInput<'_>, out: &TrimOutput) -> Result<(), String> {
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    let first: Vec<u32> = (0..)
        .zip(input.places)
        .map(|(v, p)| *known.entry((*p + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert(v))
        .collect();
    let one = |v: u32| first.get(v as usize).copied().unwrap_or(v);
    let mut chain: HashMap<[u32; 2], i64> = HashMap::new();
    let mut add = |a: u32, b: u32, times: i64| {
        let (a, b) = (one(a), one(b));
        if a != b {
            *chain.entry([a.min(b), a.max(b)]).or_default() += if a < b { times } else { -times };
        }
    };
    let once = all_triangles(input, out).into_iter().chain(out.closing.iter().copied()).map(|t| (t, 1));
    for (t, times) in once.chain(out.layers.iter().map(|&(t, times)| (t, i64::from(times)))) {
        (0..3).for_each(|k| add(t[k], t[(k + 1) % 3], times));
    }
    for w in input.loop_starts.windows(2) {
        (w[0]..w[1]).for_each(|v| add(v, if v + 1 == w[1] { w[0] } else { v + 1 }, -1));
    }
    if let Some((edge, n)) = chain.iter().find(|(_, n)| **n != 0) {
        return Err(format!("edge {edge:?} is left over {n} times"));
    }
    let repeats = |t: &&[u32; 3]| one(t[0]) == one(t[1]) || one(t[1]) == one(t[2]) || one(t[2]) == one(t[0]);
    match out.closing.iter().find(repeats) {
        Some(t) => Err(format!("the closing triangle {t:?} repeats a place")),
        None => Ok(()),
    }
}

/// In repaired tiles the boundary consists of parts of segments: both ends of an unmatched edge must lie near one
/// segment.
fn on_border_of(input: &TrimInput<'_>, out: &TrimOutput, edge: [u32; 2], exact: bool) -> bool {
    if exact {
        return false;
    }
    let ends = edge.map(|v| position(input, out, v));
    let near = |p: DVec2, a: DVec2, b: DVec2| {
        let d = b - a;
        let t = ((p - a).dot(d) / d.length_squared().max(1e-300)).clamp(0.0, 1.0);
        (a + d * t - p).length() < 1e-9
    };
    input.loop_starts.windows(2).any(|w| {
        let points = &input.points[w[0] as usize..w[1] as usize];
        (0..points.len()).any(|k| {
            let (a, b) = (points[k], points[(k + 1) % points.len()]);
            near(ends[0], a, b) && near(ends[1], a, b)
        })
    })
}

/// Checks that each point is covered as often as its winding number, by reversed triangles if that is negative. Skips
/// points within 1e-6 of a segment.
pub(crate) fn check_cover(input: &TrimInput<'_>, out: &TrimOutput) -> Result<(), String> {
    let all = all_triangles(input, out);
    let size = DVec2::new(f64::from(input.cells.0), f64::from(input.cells.1));
    for k in 0..400u32 {
        // Two irrational strides fill the tile evenly.
        let p = size * DVec2::new(f64::from(k) * 0.754_877_666, f64::from(k) * 0.569_840_291).fract();
        let (mut number, mut near) = (0, false);
        for w in input.loop_starts.windows(2) {
            let points = &input.points[w[0] as usize..w[1] as usize];
            for (k, &a) in points.iter().enumerate() {
                let b = points[(k + 1) % points.len()];
                let d = b - a;
                let t = ((p - a).dot(d) / d.length_squared().max(1e-300)).clamp(0.0, 1.0);
                near |= (a + d * t - p).length() < 1e-6;
                if a.y <= p.y {
                    number += i32::from(b.y > p.y && orient2d(a, b, p) > 0.0);
                } else {
                    number -= i32::from(b.y <= p.y && orient2d(a, b, p) < 0.0);
                }
            }
        }
        let covers = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(|v| position(input, out, v));
            [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| orient2d(from, to, p) > 0.0)
        };
        let edge_of_one = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| position(input, out, v));
            [(a, b), (b, c), (c, a)].iter().any(|&(from, to)| orient2d(from, to, p) == 0.0)
        };
        let layers = out.layers.iter().filter(|(t, _)| covers(&t)).map(|(_, times)| times);
        let covering = all.iter().filter(covers).count() as i32 + layers.sum::<i32>();
        if !near && covering != number && !all.iter().any(edge_of_one) {
            return Err(format!("{p} has winding number {number} and lies in {covering} triangles"));
        }
    }
    Ok(())
}
