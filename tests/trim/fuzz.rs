//! Random tiles: the ladder and the reference triangulation against the checker.

use std::cell::RefCell;
use std::time::{Duration, Instant};

use arbitrary::{Result, Unstructured};
use trimtess::frame::internals::trim::{TrimOutcome, TrimOutput, TrimScratch, reference, trim_tile};

use crate::checker::{Tile, check, check_boundary, check_cover};
use crate::generator::{Mode, any_tile, crossing_tile, tile, touching_tile};
use crate::sequence::judge;

/// Inputs per test: a second or two.
const COUNT: u64 = 400;
/// Inputs of arbitrary loops. One in a hundred is large; most of the others take microseconds.
const ANY_COUNT: u64 = 20_000;
/// Maximum bytes per input. A number takes four.
const MOST_BYTES: usize = 20_000;

thread_local! {
    /// State shared by all inputs of a test, since a scratch must not influence results.
    static SHARED: RefCell<(TrimScratch, TrimOutput, Tally)> = RefCell::default();
}

#[derive(Default)]
struct Tally {
    tiles: u32,
    tessellants: usize,
    certified: u32,
    cdt: u32,
    repaired: u32,
    whole: u32,
    led: u32,
    slowest: Duration,
}

/// Triangulates a drawn tile and lets `judge` check the result; does nothing if the draw was refused. Prints a failure
/// as a test.
fn drawn(tile: Result<Option<Tile>>, judge: impl Fn(&Tile, &TrimOutput) -> std::result::Result<(), String>) {
    let Ok(Some(tile)) = tile else { return };
    SHARED.with_borrow_mut(|(scratch, out, tally)| {
        let start = Instant::now();
        let outcome = trim_tile(&tile.input(), scratch, out).expect("valid input");
        tally.slowest = tally.slowest.max(start.elapsed());
        if let Err(fault) = check_boundary(&tile.input(), out).and_then(|()| judge(&tile, out)) {
            panic!("{fault}\n{:?}\n\n{}\n", out.stats, tile.as_test());
        }
        tally.tiles += 1;
        tally.tessellants += tile.points.len();
        tally.certified += u32::from(outcome == TrimOutcome::Certified);
        tally.cdt += u32::from(outcome == TrimOutcome::Cdt);
        tally.repaired += u32::from(is_repaired(out));
        tally.whole += u32::from(out.stats.whole_tile);
        tally.led += u32::from(out.stats.led > 0);
    });
}

fn is_repaired(out: &TrimOutput) -> bool {
    matches!(out.stats.outcome, TrimOutcome::Repaired { .. })
}

/// Counts of a test's tiles.
fn tally() -> Tally {
    let tally = SHARED.take().2;
    let Tally { tiles, tessellants, certified, cdt, repaired, whole, led, slowest } = tally;
    println!(
        "{tiles} tiles, {tessellants} tessellants; certified {certified}, cdt {cdt}, \
         repaired {repaired}, of these whole tile {whole}; led {led}; the slowest took {slowest:?}"
    );
    tally
}

fn as_reference(tile: &Tile, out: &TrimOutput) -> std::result::Result<(), String> {
    let facts = check(&tile.input(), out, true)?;
    if is_repaired(out) {
        return Err("simple loops need no repair".into());
    }
    let mut plain = TrimOutput::default();
    reference::trim_tile_reference(&tile.input(), &mut plain).map_err(|error| error.to_string())?;
    let plain = check(&tile.input(), &plain, true).map_err(|fault| format!("reference: {fault}"))?;
    let same = (facts.area - plain.area).abs() <= 1e-12 * plain.area.max(1.0);
    if same { Ok(()) } else { Err(format!("{facts:?} {plain:?}")) }
}

#[test]
fn fuzz_simple_loops() {
    judge!(COUNT, MOST_BYTES, |bytes: &[u8]| {
        let mut u = Unstructured::new(bytes);
        drawn(u.choose(&Mode::ALL).copied().and_then(|mode| tile(&mut u, mode)), as_reference);
    });
    assert!(tally().tiles > 0, "the generator must not refuse everything");
}

/// Crossing loops: no panic, and positive, matching triangles that cover the points around which the loops wind.
#[test]
fn fuzz_crossing_loops() {
    judge!(COUNT, MOST_BYTES, |bytes: &[u8]| {
        drawn(crossing_tile(&mut Unstructured::new(bytes)), |tile, out| {
            let input = tile.input();
            if out.stats.led > 0 {
                return Ok(());
            }
            let matched = if is_repaired(out) { check(&input, out, false).map(|_| ()) } else { Ok(()) };
            matched.and_then(|()| check_cover(&input, out))
        });
    });
    let Tally { repaired, led, .. } = tally();
    assert!(repaired > 10 * led);
}

/// Arbitrary loops: the boundary is the loops.
#[test]
fn fuzz_any_loops() {
    judge!(ANY_COUNT, MOST_BYTES, |bytes: &[u8]| {
        drawn(any_tile(&mut Unstructured::new(bytes)).map(Some), |_, _| Ok(()));
    });
    assert!(tally().repaired > 0);
}

/// Loops that touch at tessellants, and slits: as exact as simple loops, unless the reference finds that they overlap
/// too.
#[test]
fn fuzz_touching_loops() {
    judge!(COUNT, MOST_BYTES, |bytes: &[u8]| {
        drawn(touching_tile(&mut Unstructured::new(bytes)), |tile, out| {
            let mut plain = TrimOutput::default();
            reference::trim_tile_reference(&tile.input(), &mut plain).map_err(|error| error.to_string())?;
            if is_repaired(out) && !is_repaired(&plain) {
                return Err("the reference needs no repair".into());
            }
            for result in [out, &plain] {
                check(&tile.input(), result, !is_repaired(result))?;
                check_cover(&tile.input(), result)?;
            }
            Ok(())
        });
    });
    let Tally { tiles, repaired, .. } = tally();
    assert!(tiles > repaired);
}
