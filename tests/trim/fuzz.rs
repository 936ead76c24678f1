//! Random tiles: the ladder and the reference against the checker.
//!
//! `TRIMTESS_FUZZ_MS` is the time per test in milliseconds.

use std::cell::RefCell;

use arbtest::arbtest;
use trimtess::frame::trim::{TrimOutcome, TrimOutput, TrimScratch, reference, trim_tile};

use crate::checker::{check, check_chain, check_cover};
use crate::generator::{Mode, crossing_tile, tile, touching_tile};

/// Enough for a few hundred tiles per mode in a default run.
const DEFAULT_MS: u64 = 1_000;

fn budget() -> u64 {
    std::env::var("TRIMTESS_FUZZ_MS").ok().and_then(|ms| ms.parse().ok()).unwrap_or(DEFAULT_MS)
}

#[derive(Default)]
struct Tally {
    tiles: u32,
    tessellants: usize,
    certified: u32,
    merged: u32,
    cdt: u32,
    whole: u32,
    retraced: u32,
}

fn fuzz(mode: Mode) {
    let state = RefCell::new((TrimScratch::default(), TrimOutput::default(), Tally::default()));
    arbtest(|u| {
        let Some(tile) = tile(u, mode)? else { return Ok(()) };
        let (scratch, out, tally) = &mut *state.borrow_mut();
        let outcome = trim_tile(&tile.input(), scratch, out).expect("valid input");
        let facts =
            check(&tile.input(), out, true).unwrap_or_else(|fault| panic!("{fault}\n{:?}\n{tile:?}", out.stats));
        assert!(!matches!(outcome, TrimOutcome::Repaired { .. }), "simple loops need no repair: {tile:?}");
        let mut plain = TrimOutput::default();
        reference::trim_tile_reference(&tile.input(), &mut plain).expect("valid input");
        let plain = check(&tile.input(), &plain, true).unwrap_or_else(|fault| panic!("reference: {fault}\n{tile:?}"));
        assert!((facts.area - plain.area).abs() <= 1e-12 * plain.area.max(1.0), "{facts:?} {plain:?}");
        tally.tiles += 1;
        tally.tessellants += tile.points.len();
        tally.certified += u32::from(outcome == TrimOutcome::Certified);
        tally.merged += u32::from(outcome == TrimOutcome::Merged);
        tally.cdt += u32::from(outcome == TrimOutcome::Cdt);
        tally.whole += u32::from(out.stats.whole_tile);
        tally.retraced += u32::from(out.stats.retraced);
        Ok(())
    })
    .size_min(2_000)
    .size_max(20_000)
    .budget_ms(budget())
    .run();
    let Tally { tiles, tessellants, certified, merged, cdt, whole, retraced } = state.into_inner().2;
    println!(
        "{mode:?}: {tiles} tiles, {tessellants} tessellants; certified {certified}, merged {merged}, cdt {cdt}, \
         of these whole tile {whole}; retraced {retraced}"
    );
    assert!(tiles > 0, "the generator must not refuse everything");
}

#[test]
fn random() {
    fuzz(Mode::Random);
}

#[test]
fn corners() {
    fuzz(Mode::Corners);
}

#[test]
fn quarters() {
    fuzz(Mode::Quarters);
}

#[test]
fn lattice_rectangles() {
    fuzz(Mode::LatticeRectangles);
}

#[test]
fn spiky() {
    fuzz(Mode::Spiky);
}

#[test]
fn tiny() {
    fuzz(Mode::Tiny);
}

#[test]
fn long() {
    fuzz(Mode::Long);
}

#[test]
fn near_corners() {
    fuzz(Mode::NearCorners);
}

#[test]
fn bites() {
    fuzz(Mode::Bites);
}

#[test]
fn outer() {
    fuzz(Mode::Outer);
}

/// Loops that cross: no panic, positive triangles that match, over the points that the loops wind around.
#[test]
fn crossing_loops_are_repaired() {
    let state = RefCell::new((TrimScratch::default(), TrimOutput::default(), [0u32; 2]));
    arbtest(|u| {
        let Some(tile) = crossing_tile(u)? else { return Ok(()) };
        let (scratch, out, [tiles, repaired]) = &mut *state.borrow_mut();
        let outcome = trim_tile(&tile.input(), scratch, out).expect("valid input");
        let exact = !matches!(outcome, TrimOutcome::Repaired { .. });
        let checked =
            if exact { check_chain(&tile.input(), out) } else { check(&tile.input(), out, false).map(|_| ()) };
        checked
            .and_then(|()| check_cover(&tile.input(), out))
            .unwrap_or_else(|fault| panic!("{fault}\n{:?}\n{tile:?}", out.stats));
        *tiles += 1;
        *repaired += u32::from(!exact);
        Ok(())
    })
    .size_min(1_000)
    .size_max(8_000)
    .budget_ms(budget())
    .run();
    let [tiles, repaired] = state.into_inner().2;
    println!("crossing: {tiles} tiles, {repaired} repaired");
    assert!(repaired > 0);
}

/// Loops that touch at tessellants, and slits: as exact as simple loops, unless the reference finds that they overlap too.
#[test]
fn touching_loops() {
    let state = RefCell::new((TrimScratch::default(), TrimOutput::default(), [0u32; 2]));
    arbtest(|u| {
        let Some(tile) = touching_tile(u)? else { return Ok(()) };
        let (scratch, out, [tiles, repaired]) = &mut *state.borrow_mut();
        let mut plain = TrimOutput::default();
        let repair = |outcome| matches!(outcome, TrimOutcome::Repaired { .. });
        let outcome = trim_tile(&tile.input(), scratch, out).expect("valid input");
        let wanted = reference::trim_tile_reference(&tile.input(), &mut plain).expect("valid input");
        assert!(repair(wanted) || !repair(outcome), "{outcome:?} {wanted:?} {tile:?}");
        for result in [&*out, &plain] {
            check(&tile.input(), result, !repair(result.stats.outcome))
                .and_then(|_| check_cover(&tile.input(), result))
                .unwrap_or_else(|fault| panic!("{fault}\n{:?}\n{tile:?}", result.stats));
        }
        *tiles += 1;
        *repaired += u32::from(repair(outcome));
        Ok(())
    })
    .size_min(1_000)
    .size_max(4_000)
    .budget_ms(budget())
    .run();
    let [tiles, repaired] = state.into_inner().2;
    println!("touching: {tiles} tiles, {repaired} of them overlap");
    assert!(tiles > repaired);
}
