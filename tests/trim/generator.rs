//! Random bytes -> tiles with simple, nested, oriented loops and one kind of difficulty each.

use std::f64::consts::TAU;

use crate::common::winding;
use arbitrary::{Result, Unstructured};
use glam::{DVec2, DVec3};
use trimtess::math::predicates::orient2d;

use crate::cases::border;
use crate::checker::{Tile, area};

/// The difficulty that the loops of a tile share.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Mode {
    /// Wavy loops of up to 63 segments.
    Random,
    /// All tessellants on lattice corners.
    Corners,
    /// All tessellants on quarters of cells.
    Quarters,
    /// Rectangles whose sides run along lattice lines.
    LatticeRectangles,
    /// Up to 154 tessellants with jumping radii.
    Spiky,
    /// Up to 19 loops, many inside one cell.
    Tiny,
    /// Triangles to heptagons with segments over many cells.
    Long,
    /// Tessellants next to lattice corners, 1e-15 to 2e-3 away.
    NearCorners,
    /// A border with dents.
    Bites,
    /// No border: the outer loop is a trim loop.
    Outer,
}

impl Mode {
    pub(crate) const ALL: [Self; 10] = [
        Self::Random,
        Self::Corners,
        Self::Quarters,
        Self::LatticeRectangles,
        Self::Spiky,
        Self::Tiny,
        Self::Long,
        Self::NearCorners,
        Self::Bites,
        Self::Outer,
    ];
}

/// A number in `low..=high`.
fn range(u: &mut Unstructured<'_>, low: f64, high: f64) -> Result<f64> {
    Ok(low + (high - low) * f64::from(u.int_in_range(0..=u32::MAX)?) / f64::from(u32::MAX))
}

fn below(u: &mut Unstructured<'_>, n: u32) -> Result<u32> {
    u.int_in_range(0..=n - 1)
}

/// A tile; `None` if the drawn loops touch or cross.
pub(crate) fn tile(u: &mut Unstructured<'_>, mode: Mode) -> Result<Option<Tile>> {
    let cells = (1 + below(u, 24)?, 1 + below(u, 24)?);
    let size = DVec2::new(f64::from(cells.0), f64::from(cells.1));
    let mut loops = vec![if mode == Mode::Outer { outer_loop(u, size)? } else { border_loop(u, size, mode)? }];
    if !simple(&loops) {
        return Ok(None);
    }
    for _ in 0..below(u, if mode == Mode::Tiny { 20 } else { 5 })? {
        add_hole(u, size, mode, &mut loops)?;
    }
    if u.arbitrary()? {
        for points in &mut loops {
            *points = cut(points);
        }
        if !simple(&loops) {
            return Ok(None);
        }
    }
    Ok(nested(&loops).then(|| Tile::new(cells, &loops)))
}

fn outer_loop(u: &mut Unstructured<'_>, size: DVec2) -> Result<Vec<DVec2>> {
    let count = 3 + below(u, 60)?;
    let (wave, phase) = (range(u, 0.0, 0.4)?, range(u, 0.0, TAU)?);
    let point = |k| {
        let angle = TAU * f64::from(k) / f64::from(count);
        let radius = 0.45 * (1.0 + wave * (3.0 * angle + phase).sin()) / 1.4 * range(u, 0.8, 1.0)?;
        Ok(0.5 * size + size * radius * DVec2::from_angle(angle))
    };
    (0..count).map(point).collect()
}

/// The tile's border with an own number of segments on each side. With bites, some segments dent inwards.
fn border_loop(u: &mut Unstructured<'_>, size: DVec2, mode: Mode) -> Result<Vec<DVec2>> {
    let corners = [DVec2::ZERO, DVec2::new(size.x, 0.0), size, DVec2::new(0.0, size.y)];
    let mut points = Vec::new();
    for side in 0..4 {
        let (a, b) = (corners[side], corners[(side + 1) % 4]);
        let count = 1 + below(u, 30)?;
        let step = (b - a) / f64::from(count);
        let inwards = step.perp().normalize();
        for k in 0..count {
            let start = a + (b - a) * (f64::from(k) / f64::from(count));
            points.push(start);
            if mode == Mode::Bites && k > 0 && u.ratio(1, 4)? {
                let dents = 1 + below(u, 5)?;
                let depth = range(u, 0.05, 0.4)? * size.min_element();
                for dent in 1..=dents {
                    let along = f64::from(dent) / f64::from(dents + 1);
                    points.push(start + step * along + inwards * (depth * range(u, 0.1, 1.0)?));
                }
            }
        }
    }
    Ok(points)
}

fn add_hole(u: &mut Unstructured<'_>, size: DVec2, mode: Mode, loops: &mut Vec<Vec<DVec2>>) -> Result<()> {
    let centre = DVec2::new(range(u, 0.0, size.x)?, range(u, 0.0, size.y)?);
    let largest = if mode == Mode::Tiny { 0.8 } else { 0.45 * size.min_element() };
    let radius = range(u, 0.02, largest)?;
    let count = match mode {
        Mode::Long => 3 + below(u, 5)?,
        Mode::Spiky => 5 + below(u, 150)?,
        _ => 3 + below(u, 60)?,
    };
    let waves = [range(u, 0.0, 0.4)?, range(u, 0.0, TAU)?, range(u, 0.0, 0.3)?, range(u, 0.0, TAU)?];
    let jump = if mode == Mode::Spiky { range(u, 0.0, 0.9)? } else { 0.0 };
    let offset = [1e-15, 1e-12, 1e-9, 1e-6, 2e-3][below(u, 5)? as usize];
    let mut points = Vec::new();
    for k in 0..count {
        let angle = -TAU * f64::from(k) / f64::from(count);
        let wave = 1.0 + waves[0] * (3.0 * angle + waves[1]).sin() + waves[2] * (5.0 * angle + waves[3]).sin();
        let shrink = if jump > 0.0 { 1.0 - jump * range(u, 0.0, 1.0)? } else { 1.0 };
        let p = centre + DVec2::from_angle(angle) * (radius * wave * shrink);
        points.push(match mode {
            Mode::Corners => p.round(),
            Mode::Quarters => (p * 4.0).round() / 4.0,
            Mode::NearCorners => {
                let shift = DVec2::new(f64::from(below(u, 3)?) - 1.0, f64::from(below(u, 3)?) - 1.0);
                p.round() + shift * offset
            }
            _ => p,
        });
    }
    if mode == Mode::LatticeRectangles {
        let (c, r) = (centre.round(), radius.round().max(1.0));
        points = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| c + r * DVec2::new(x, y)).into();
    }
    points.dedup();
    while points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    let inside = |p: &DVec2| p.cmpge(DVec2::splat(1e-3)).all() && p.cmple(size - 1e-3).all();
    if points.len() < 3 || area(&points) >= -1e-9 || !points.iter().all(inside) {
        return Ok(());
    }
    loops.push(points);
    if !simple(loops) {
        loops.pop();
        return Ok(());
    }
    let with_islands =
        matches!(mode, Mode::Spiky | Mode::Tiny | Mode::Long | Mode::NearCorners | Mode::Bites | Mode::Outer);
    if with_islands && u.ratio(1, 3)? {
        let scale = range(u, 0.2, 0.9)?;
        let hole = &loops[loops.len() - 1];
        let island: Vec<DVec2> = hole.iter().rev().map(|p| centre + (p - centre) * scale).collect();
        let within = |p: &DVec2| winding(hole, *p) == -1;
        if area(&island) > 1e-9 && island.iter().all(within) {
            loops.push(island);
            if !simple(loops) {
                loops.pop();
            }
        }
    }
    Ok(())
}

/// Cuts all segments to at most one cell.
fn cut(points: &[DVec2]) -> Vec<DVec2> {
    let mut out = Vec::new();
    for (k, &a) in points.iter().enumerate() {
        let d = points[(k + 1) % points.len()] - a;
        let parts = d.abs().max_element().ceil().max(1.0) as u32;
        out.extend((0..parts).map(|part| a + d * (f64::from(part) / f64::from(parts))));
    }
    out
}

/// Whether every hole lies in the first loop and in no other hole, and every island in exactly one hole.
fn nested(loops: &[Vec<DVec2>]) -> bool {
    loops.iter().enumerate().all(|(k, points)| {
        let around: i32 =
            loops.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, l)| winding(l, points[0])).sum();
        around == if area(points) > 0.0 { 0 } else { 1 }
    })
}

/// Whether no two segments meet except at the tessellant they share.
pub(crate) fn simple(loops: &[Vec<DVec2>]) -> bool {
    struct Segment {
        a: DVec2,
        b: DVec2,
        index: usize,
        next: usize,
    }
    let mut segments = Vec::new();
    for points in loops {
        let first = segments.len();
        for (k, &a) in points.iter().enumerate() {
            let next = (k + 1) % points.len();
            segments.push(Segment { a, b: points[next], index: first + k, next: first + next });
        }
    }
    segments.sort_by(|s, t| s.a.x.min(s.b.x).total_cmp(&t.a.x.min(t.b.x)));
    for (k, s) in segments.iter().enumerate() {
        for t in &segments[k + 1..] {
            if t.a.x.min(t.b.x) > s.a.x.max(s.b.x) {
                break;
            }
            let bad = if s.next == t.index {
                folds(s.a, s.b, t.b)
            } else if t.next == s.index {
                folds(t.a, t.b, s.b)
            } else {
                meet(s.a, s.b, t.a, t.b)
            };
            if bad {
                return false;
            }
        }
    }
    true
}

/// Whether the path a, b, c turns back onto itself.
fn folds(a: DVec2, b: DVec2, c: DVec2) -> bool {
    orient2d(a, b, c) == 0.0 && (c - b).dot(a - b) > 0.0
}

fn meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    if a.max(b).cmplt(c.min(d)).any() || c.max(d).cmplt(a.min(b)).any() {
        return false;
    }
    let between = |p: DVec2, q: DVec2, r: DVec2| r.cmpge(p.min(q)).all() && r.cmple(p.max(q)).all();
    let [c_side, d_side, a_side, b_side] = [orient2d(a, b, c), orient2d(a, b, d), orient2d(c, d, a), orient2d(c, d, b)];
    let across = |s: f64, t: f64| s > 0.0 && t < 0.0 || s < 0.0 && t > 0.0;
    (across(c_side, d_side) && across(a_side, b_side))
        || (c_side == 0.0 && between(a, b, c))
        || (d_side == 0.0 && between(a, b, d))
        || (a_side == 0.0 && between(c, d, a))
        || (b_side == 0.0 && between(c, d, b))
}

/// A tile whose holes are moved until they cross something.
pub(crate) fn crossing_tile(u: &mut Unstructured<'_>) -> Result<Option<Tile>> {
    let cells = (1 + below(u, 12)?, 1 + below(u, 12)?);
    let size = DVec2::new(f64::from(cells.0), f64::from(cells.1));
    let mut loops = vec![border(cells, 1 + below(u, 6)?)];
    for _ in 0..1 + below(u, 4)? {
        let centre = DVec2::new(range(u, 0.0, size.x)?, range(u, 0.0, size.y)?);
        let (radius, jitter) = (range(u, 0.1, 0.5)? * size.max_element(), range(u, 0.0, 2.0)?);
        let count = 3 + below(u, 40)?;
        let snapped = u.ratio(1, 3)?;
        let mut points = Vec::new();
        for k in 0..count {
            let shake = DVec2::new(range(u, -0.5, 0.5)?, range(u, -0.5, 0.5)?) * jitter;
            let p = centre + DVec2::from_angle(-TAU * f64::from(k) / f64::from(count)) * radius + shake;
            let p = if snapped { p.round() } else { p };
            points.push(p.clamp(DVec2::ZERO, size));
        }
        loops.push(points);
    }
    Ok((!simple(&loops)).then(|| Tile::new(cells, &loops)))
}

/// A tile with slits, whose loops touch each other, themselves and the border at tessellants.
pub(crate) fn touching_tile(u: &mut Unstructured<'_>) -> Result<Option<Tile>> {
    let cells = (1 + below(u, 4)?, 1 + below(u, 4)?);
    let size = DVec2::new(f64::from(cells.0), f64::from(cells.1));
    // Coordinates are multiples of a quarter, or of a number that misses the lattice lines.
    let grain = *u.choose(&[0.25, 1.0 / 3.0, 0.5])?;
    let on_grid = |p: DVec2| ((p / grain).round() * grain).clamp(DVec2::ZERO, size);
    let mut loops = vec![border(cells, (1.0 / grain).round() as u32 * cells.0.max(cells.1))];
    for _ in 0..1 + below(u, 5)? {
        let centre = DVec2::new(range(u, 0.0, size.x)?, range(u, 0.0, size.y)?);
        let (radius, count) = (range(u, 0.2, 0.5)? * size.min_element(), 3 + below(u, 8)?);
        let mut points: Vec<DVec2> = Vec::new();
        for k in 0..count {
            let p = centre + DVec2::from_angle(-TAU * f64::from(k) / f64::from(count)) * radius * range(u, 0.5, 1.2)?;
            points.push(on_grid(p));
            if u.ratio(1, 6)? {
                let tip = on_grid(p + DVec2::new(range(u, -1.0, 1.0)?, range(u, -1.0, 1.0)?));
                points.extend([tip, on_grid(p)]);
            }
        }
        loops.push(points);
        let segments = segments(&loops);
        let bad = segments.iter().enumerate().any(|(k, s)| segments[k + 1..].iter().any(|t| overlap(*s, *t)));
        if bad {
            loops.pop();
        }
    }
    Ok((loops.len() > 1).then(|| Tile::new(cells, &loops)))
}

fn segments(loops: &[Vec<DVec2>]) -> Vec<[DVec2; 2]> {
    let of_loop = |l: &Vec<DVec2>| (0..l.len()).map(|k| [l[k], l[(k + 1) % l.len()]]).collect::<Vec<_>>();
    loops.iter().flat_map(of_loop).filter(|s| s[0] != s[1]).collect()
}

/// Whether the segments meet elsewhere than at common ends and are not each other's reverse.
fn overlap([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    if (a, b) == (d, c) {
        return false;
    }
    let common = [a == c, a == d, b == c, b == d].iter().filter(|&&equal| equal).count();
    match common {
        0 => meet(a, b, c, d),
        1 => {
            let (at, p, q) = if a == c {
                (a, b, d)
            } else if a == d {
                (a, b, c)
            } else if b == c {
                (b, a, d)
            } else {
                (b, a, c)
            };
            folds(p, at, q)
        }
        _ => true,
    }
}

/// A tile of arbitrary loops: random walks, stars, spikes and curls, on and off lattice lines, repeated or reversed. A
/// point's place in space is its own, that of its coordinates, or one of a few.
pub(crate) fn any_tile(u: &mut Unstructured<'_>) -> Result<Tile> {
    let cells = (1 + below(u, 6)?, 1 + below(u, 6)?);
    let size = DVec2::new(f64::from(cells.0), f64::from(cells.1));
    let grain = *u.choose(&[0.0, 0.0, 0.25, 1.0, 1.0 / 3.0])?;
    let large = u.ratio(1, 100)?;
    let mut loops: Vec<Vec<DVec2>> = if u.arbitrary()? { vec![border(cells, 1 + below(u, 4)?)] } else { Vec::new() };
    for _ in 0..1 + below(u, 4)? {
        let count = if large { 60 + below(u, 140)? } else { 1 + below(u, 20)? };
        let l = any_loop(u, size, count)?;
        let on_grid = |p: DVec2| if grain > 0.0 { (p / grain).round() * grain } else { p };
        let mut l: Vec<DVec2> = l.into_iter().map(|p| on_grid(p).clamp(DVec2::ZERO, size)).collect();
        match below(u, 8)? {
            0 => l = [&l[..], &l[..]].concat(),
            1 => loops.push(l.iter().rev().copied().collect()),
            2 => loops.push(l.clone()),
            _ => {}
        }
        loops.push(l);
    }
    let mut tile = Tile::new(cells, &loops);
    let places = below(u, 4)?;
    for (k, place) in tile.places.iter_mut().enumerate() {
        match places {
            0 => place.z = k as f64,
            1 => *place = DVec3::new(f64::from(below(u, 5)?), 0.0, 0.0),
            2 if u.ratio(1, 5)? => place.z = 1.0,
            _ => {}
        }
    }
    Ok(tile)
}

/// Corners of a loop around or within a box.
fn any_loop(u: &mut Unstructured<'_>, size: DVec2, count: u32) -> Result<Vec<DVec2>> {
    let at = |u: &mut Unstructured<'_>| Ok(DVec2::new(range(u, 0.0, size.x)?, range(u, 0.0, size.y)?));
    let kind = below(u, 5)?;
    let (centre, turns) = (at(u)?, 1 + below(u, 4)?);
    let radius = range(u, 0.0, 0.7)? * size.max_element();
    let mut points = Vec::new();
    for k in 0..count {
        let angle = TAU * f64::from(k * turns) / f64::from(count);
        points.push(match kind {
            // Anywhere: as many crossings as possible.
            0 => at(u)?,
            // A star, or a circle traversed several times.
            1 => centre + DVec2::from_angle(angle) * radius,
            // A curl that winds inwards.
            2 => centre + DVec2::from_angle(3.0 * angle) * radius * f64::from(k) / f64::from(count),
            // Spikes out and back.
            3 if k % 2 == 0 => centre,
            3 => at(u)?,
            // Steps along the axes.
            _ => {
                let last = points.last().copied().unwrap_or(centre);
                let to = at(u)?;
                if k % 2 == 0 { DVec2::new(to.x, last.y) } else { DVec2::new(last.x, to.y) }
            }
        });
    }
    Ok(points)
}
