//! The bytes of a STEP file -> the same file with every CARTESIAN_POINT moved at random, or those of edges rounded. All
//! other bytes stay.
#![allow(dead_code, reason = "not every test uses all of it")]

use crate::random::SplitMix;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// A CARTESIAN_POINT.
struct Point {
    entity: u64,
    /// Byte ranges of its coordinates in the file.
    at: Vec<Range<usize>>,
    coordinates: Vec<f64>,
    /// Diagonal of its part, in the file's unit; for points in (u,v) that of their curve.
    size: f64,
    /// Whether it belongs to the curve or an end of an edge.
    on_edge: bool,
}

/// An instance: the first word of its type, and its references.
struct Instance<'a> {
    kind: &'a str,
    refers_to: Vec<u64>,
}

/// A file and the points in it.
pub(crate) struct Points<'a> {
    bytes: &'a [u8],
    all: Vec<Point>,
}

impl<'a> Points<'a> {
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        let mut all = Vec::new();
        let mut instances = HashMap::new();
        let mut order = Vec::new();
        for statement in statements(bytes) {
            let Some((entity, instance)) = instance(bytes, statement.clone()) else { continue };
            if instance.kind == "CARTESIAN_POINT" {
                let at = numbers(bytes, statement);
                let parsed =
                    |range: &Range<usize>| std::str::from_utf8(&bytes[range.clone()]).ok()?.parse::<f64>().ok();
                let coordinates: Vec<f64> = at.iter().filter_map(parsed).collect();
                if coordinates.len() == at.len() {
                    all.push(Point { entity, at, coordinates, size: 0.0, on_edge: false });
                }
            }
            order.push(entity);
            instances.insert(entity, instance);
        }
        let mut points = Self { bytes, all };
        points.measure(&instances, &order);
        points
    }

    /// Number of points.
    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// Sets the sizes of parts, and which points belong to edges.
    fn measure(&mut self, instances: &HashMap<u64, Instance<'_>>, order: &[u64]) {
        let rows: HashMap<u64, usize> = self.all.iter().enumerate().map(|(row, point)| (point.entity, row)).collect();
        let is_representation = |kind: &str| kind.ends_with("REPRESENTATION");
        let is_surface = |kind: &str| kind == "PCURVE" || kind.contains("SURFACE") && !kind.contains("CURVE");
        let mut largest = 0.0_f64;
        let mut edges = HashSet::new();
        for root in order {
            let kind = instances[root].kind;
            if kind == "EDGE_CURVE" {
                reach(instances, *root, is_surface, &mut edges);
            }
            if !kind.ends_with("SHAPE_REPRESENTATION") && kind != "DEFINITIONAL_REPRESENTATION" {
                continue;
            }
            let mut reached = HashSet::new();
            reach(instances, *root, is_representation, &mut reached);
            let vertices =
                reached.iter().filter(|entity| instances.get(entity).is_some_and(|i| i.kind == "VERTEX_POINT"));
            let vertices: Vec<u64> = vertices.flat_map(|entity| &instances[entity].refers_to).copied().collect();
            let of: Vec<u64> = if vertices.is_empty() { reached.iter().copied().collect() } else { vertices };
            let size =
                diagonal(of.iter().filter_map(|entity| rows.get(entity)).map(|&row| &self.all[row].coordinates[..]));
            if kind != "DEFINITIONAL_REPRESENTATION" {
                largest = largest.max(size);
            }
            for row in reached.iter().filter_map(|entity| rows.get(entity)) {
                let point = &mut self.all[*row];
                point.size = if point.size > 0.0 { point.size } else { size };
            }
        }
        for point in &mut self.all {
            point.on_edge = edges.contains(&point.entity);
            if point.size == 0.0 && point.coordinates.len() == 3 {
                point.size = largest; // placements of parts
            }
        }
    }

    /// The file with every point moved by at most `share` of its part's size.
    pub(crate) fn moved(&self, share: f64, random: &mut SplitMix) -> Vec<u8> {
        self.edited(|point| {
            let reach = share * point.size / (point.coordinates.len() as f64).sqrt();
            Some(point.coordinates.iter().map(|x| x + reach * random.range(-1.0, 1.0)).collect())
        })
    }

    /// The file with every point in space moved by the same `shift`, in the file's unit.
    pub(crate) fn shifted(&self, shift: [f64; 3]) -> Vec<u8> {
        self.edited(|point| {
            let in_space = point.coordinates.len() == 3;
            in_space.then(|| point.coordinates.iter().zip(shift).map(|(x, by)| x + by).collect())
        })
    }

    /// The file with the points of edges rounded to multiples of `share` of their part's size.
    pub(crate) fn rounded(&self, share: f64) -> Vec<u8> {
        self.edited(|point| {
            let step = share * point.size;
            let usable = point.on_edge && step > 0.0;
            usable.then(|| point.coordinates.iter().map(|x| (x / step).round() * step).collect())
        })
    }

    /// The file with the coordinates that `others` gives; other points stay.
    fn edited(&self, mut others: impl FnMut(&Point) -> Option<Vec<f64>>) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.bytes.len() + 16 * self.all.len());
        let mut done = 0;
        for point in &self.all {
            let Some(coordinates) = others(point) else { continue };
            for (at, x) in point.at.iter().zip(coordinates) {
                out.extend_from_slice(&self.bytes[done..at.start]);
                // A real of Part 21 has a point before its exponent; 17 digits represent every double.
                out.extend(format!("{x:.16E}").bytes());
                done = at.end;
            }
        }
        out.extend_from_slice(&self.bytes[done..]);
        out
    }
}

/// Collects all instances that `root` refers to, directly or not, itself included. Does not follow types for which
/// `stop` holds.
fn reach(instances: &HashMap<u64, Instance<'_>>, root: u64, stop: impl Fn(&str) -> bool, reached: &mut HashSet<u64>) {
    let mut open = vec![root];
    while let Some(entity) = open.pop() {
        let Some(instance) = instances.get(&entity) else { continue };
        if (entity == root || !stop(instance.kind)) && reached.insert(entity) {
            open.extend(&instance.refers_to);
        }
    }
}

/// Diagonal of the box of the points that have as many coordinates as the first.
fn diagonal<'a>(points: impl Iterator<Item = &'a [f64]>) -> f64 {
    let mut ends: Option<Vec<(f64, f64)>> = None;
    for point in points {
        let ends = ends.get_or_insert_with(|| point.iter().map(|&x| (x, x)).collect());
        if ends.len() == point.len() {
            ends.iter_mut().zip(point).for_each(|(end, &x)| *end = (end.0.min(x), end.1.max(x)));
        }
    }
    ends.unwrap_or_default().iter().map(|(low, high)| (high - low).powi(2)).sum::<f64>().sqrt()
}

/// Statements, without their semicolons. Semicolons in strings and comments do not count.
fn statements(bytes: &[u8]) -> Vec<Range<usize>> {
    let (mut all, mut start, mut at) = (Vec::new(), 0, 0);
    while at < bytes.len() {
        at = match bytes[at] {
            b'\'' => after(bytes, at + 1, b"'"),
            b'/' if bytes[at..].starts_with(b"/*") => after(bytes, at + 2, b"*/"),
            b';' => {
                all.push(start..at);
                start = at + 1;
                start
            }
            _ => at + 1,
        };
    }
    all
}

/// The position after the next `end`.
fn after(bytes: &[u8], from: usize, end: &[u8]) -> usize {
    bytes[from..].windows(end.len()).position(|w| w == end).map_or(bytes.len(), |length| from + length + end.len())
}

/// A statement as an instance `#n = …`, if it is one.
fn instance(bytes: &[u8], statement: Range<usize>) -> Option<(u64, Instance<'_>)> {
    let mut tokens = tokens(bytes, statement);
    let entity = tokens.next().and_then(|token| reference(&bytes[token]))?;
    let is_word = |token: &Range<usize>| bytes[token.start].is_ascii_uppercase();
    let kind = tokens.by_ref().find(is_word).and_then(|word| std::str::from_utf8(&bytes[word]).ok())?;
    let refers_to = tokens.filter_map(|token| reference(&bytes[token])).collect();
    Some((entity, Instance { kind, refers_to }))
}

/// The number of `#n`.
fn reference(token: &[u8]) -> Option<u64> {
    std::str::from_utf8(token.strip_prefix(b"#")?).ok()?.parse().ok()
}

/// The numbers of a statement.
fn numbers(bytes: &[u8], statement: Range<usize>) -> Vec<Range<usize>> {
    let is_number = |token: &Range<usize>| b"+-.0123456789".contains(&bytes[token.start]);
    tokens(bytes, statement).filter(is_number).collect()
}

/// References, words and numbers of a statement, except in strings and comments.
fn tokens(bytes: &[u8], statement: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let mut at = statement.start;
    std::iter::from_fn(move || {
        while at < statement.end {
            let start = at;
            match bytes[at] {
                b'\'' => at = after(bytes, at + 1, b"'"),
                b'/' if bytes[at..].starts_with(b"/*") => at = after(bytes, at + 2, b"*/"),
                b'#' | b'+' | b'-' | b'.' | b'_' | b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' => {
                    let goes_on = |byte: u8| byte.is_ascii_alphanumeric() || b"+-._".contains(&byte);
                    at += 1 + bytes[at + 1..statement.end].iter().take_while(|&&byte| goes_on(byte)).count();
                    return Some(start..at);
                }
                _ => at += 1,
            }
        }
        None
    })
}

#[test]
fn points_move_by_their_share_of_the_part_and_nothing_else_does() {
    let file = "DATA;\n#1=CARTESIAN_POINT('#2; 3.',(0.,0.,0.));\n#2 = CARTESIAN_POINT ( 'b', ( 3., 4.E0, -0.5 ) ) ;\n\
                #3=VERTEX_POINT('',#1);#4=VERTEX_POINT('',#2);/* #9=CARTESIAN_POINT('',(1.)); */\n#5=LINE('',#2,#7);\n\
                #6=EDGE_CURVE('',#3,#4,#5,.T.);#8=CARTESIAN_POINT('off',(100.,7.,0.));#7=DIRECTION('',(1.,0.,0.));\n\
                #10=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#6,#8),#11);\nENDSEC;\n";
    let points = Points::of(file.as_bytes());
    assert_eq!(points.len(), 3);
    let size = 25.25_f64.sqrt();
    assert!(points.all.iter().all(|point| (point.size - size).abs() < 1e-12));
    assert_eq!(points.all.iter().map(|point| point.on_edge).collect::<Vec<_>>(), [true, true, false]);
    let moved = points.moved(1e-3, &mut SplitMix::of("points", 0));
    let again = Points::of(&moved);
    for (before, after) in points.all.iter().zip(&again.all) {
        let by = before.coordinates.iter().zip(&after.coordinates).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
        assert!(by > 0.0 && by <= 1e-3 * size, "moved by {by}");
    }
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let back =
        again.edited(|point| points.all.iter().find(|p| p.entity == point.entity).map(|p| p.coordinates.clone()));
    assert_eq!(text(&back), text(&points.edited(|point| Some(point.coordinates.clone()))), "all other bytes stayed");
    assert_ne!(moved, points.moved(1e-3, &mut SplitMix::of("points", 1)));
    let rounded = Points::of(&points.rounded(0.1)).all.iter().map(|p| p.coordinates.clone()).collect::<Vec<_>>();
    let step = 0.1 * size;
    assert!(rounded[1].iter().all(|x| (x / step - (x / step).round()).abs() < 1e-9), "{rounded:?}");
    assert_eq!(rounded[2], [100.0, 7.0, 0.0]);
}
