//! Edges and their pcurves -> samples along the pcurves, which every plan compares with its lattices.

use super::prepared::{EdgeImages, ImageSpan, PreparedEdge, Tile};
use crate::control::Call;
use crate::prepare::uv::uv_curve::UvCurve;
use smallvec::SmallVec;

/// Maximum steps per strip: enough to notice a lattice that is denser at one end of the strip.
pub(super) const STEPS: usize = 4;
/// Share of the tile that a step may cross before strips get more steps.
const REACH: f64 = 1.0 / 32.0;

impl EdgeImages {
    /// Samples all uses of an edge.
    fn of(edge: &PreparedEdge, tiles: &[Tile]) -> Self {
        let spans = Vec::with_capacity(edge.uses.len());
        let mut out = Self { cuts: dense(edge, tiles), spans, ..Self::default() };
        let most = edge.bounds.breaks.len().max(out.cuts.len());
        let mut strips: SmallVec<[(f64, f64); 8]> = SmallVec::with_capacity(most);
        // Most edges have two uses of their whole length.
        let whole = edge.uses.len().min(2);
        out.places.reserve_exact(whole * (1 + STEPS * (most - 1)));
        out.rates.reserve_exact(whole * (most - 1));
        for place in &edge.uses {
            let (tile, used) = (&tiles[place.tile.index()], place.of(tiles));
            let (from, to) = (edge.breaks[used.from as usize].t, edge.breaks[used.to as usize].t);
            let ends = [from.min(to), from.max(to)];
            let mut hint = used.piece as usize;
            let mut place = |t: f64| {
                let share = (used.uv.point(t, &mut hint) - tile.min) / (tile.max - tile.min);
                share.as_vec2().to_array()
            };
            let breaks = out.strips(&edge.bounds);
            let range = |strip: &[f64]| (strip[0].max(ends[0]), strip[1].min(ends[1]));
            let first = last_before(breaks, ends[0]);
            strips.clear();
            strips.extend(breaks[first..].windows(2).map(range).take_while(|(a, b)| a < b));
            let (strip, at) = (first as u32, out.places.len());
            out.places.reserve(1 + STEPS * strips.len());
            out.rates.reserve(strips.len());
            out.places.extend(strips.first().map(|strip| place(strip.0)));
            for &(a, b) in &strips {
                let step = (b - a) / STEPS as f64;
                out.places.extend((1..=STEPS).map(|i| place(a + step * i as f64)));
            }
            let steps = thin(&mut out.places, at);
            let (rate, mut ways, mut fastest) = (out.rates.len() as u32, [0.0; 2], [0.0_f32; 2]);
            for (k, (a, b)) in (0..).zip(&strips) {
                let crossings =
                    longest_step(&out.places[at + k * steps..=at + (k + 1) * steps]).map(|x| x * steps as f32);
                let rates = crossings.map(|x| rounded_down(f64::from(x) / (b - a)));
                fastest = [0, 1].map(|axis| if rates[axis] <= fastest[axis] { fastest[axis] } else { rates[axis] });
                out.rates.push(rates);
                ways = [ways[0] + crossings[0], ways[1] + crossings[1]];
            }
            out.spans.push(ImageSpan { ends, strip, place: at as u32, steps: steps as u32, rate, fastest, ways });
        }
        out.places.shrink_to_fit();
        out.rates.shrink_to_fit();
        out
    }
}

/// The strip that `t` lies in, or at whose start.
fn last_before(breaks: &[f64], t: f64) -> usize {
    breaks[1..].partition_point(|end| *end <= t).min(breaks.len() - 2)
}

/// A rate rounded down: where segments fit cells exactly, rounding up would ask for one more.
fn rounded_down(rate: f64) -> f32 {
    (rate * (1.0 - f64::from(f32::EPSILON))).min(f64::from(f32::MAX)) as f32
}

/// The longest step between places, in u and in v, as a share of the tile.
fn longest_step(places: &[[f32; 2]]) -> [f32; 2] {
    let mut within = places.iter().map(|place| place.map(|x| x.clamp(0.0, 1.0)));
    let mut from = within.next().unwrap_or_default();
    let mut most = [0.0_f32; 2];
    for to in within {
        for axis in 0..2 {
            let step = (to[axis] - from[axis]).abs();
            most[axis] = if step > most[axis] { step } else { most[axis] };
        }
        from = to;
    }
    most
}

/// Drops those places from `at` on that short strips do not need, and returns the steps left per strip.
fn thin(places: &mut Vec<[f32; 2]>, at: usize) -> usize {
    let way = |strip: &[[f32; 2]]| {
        let steps = strip.windows(2).map(|w| (w[1][0] - w[0][0]).abs().max((w[1][1] - w[0][1]).abs()));
        f64::from(steps.sum::<f32>())
    };
    let starts = (at..places.len().saturating_sub(STEPS)).step_by(STEPS);
    let longest = starts.map(|k| way(&places[k..=k + STEPS])).fold(0.0, f64::max);
    let steps = [1, 2].into_iter().find(|&steps| longest <= steps as f64 * REACH).unwrap_or(STEPS);
    if steps == STEPS {
        return STEPS;
    }
    let kept = (places.len() - at).div_ceil(STEPS / steps);
    (0..kept).for_each(|k| places[at + k] = places[at + k * (STEPS / steps)]);
    places.truncate(at + kept);
    steps
}

/// Samples the images of all edges.
pub(crate) fn sample(call: Call<'_>, edges: &mut [PreparedEdge], tiles: &[Tile]) {
    /// A few microseconds each.
    const SHARE: usize = 32;
    call.each(SHARE, edges, |edge| {
        if !call.is_cancelled() {
            edge.images = EdgeImages::of(edge, tiles);
        }
    });
}

/// Ends of an edge's strips, refined where an image turns within a strip, or is fast in a small part of one; empty if
/// none is. Close to a pole, an image crosses half a lattice in a thousandth of the edge, and only there segments have
/// to be short.
fn dense(edge: &PreparedEdge, tiles: &[Tile]) -> Vec<f64> {
    /// A strip is cut at each sample of an image if it holds at least so many. Ordinary edges have two to eight.
    const MANY: usize = 16;
    /// A strip is cut at the ends of a use's part of it if the image, at its mean speed there, would cross more tiles
    /// than this in the whole strip: the rate of the part holds for the whole strip.
    const TILES: f64 = 16.0;
    let breaks = &edge.bounds.breaks;
    let mut cuts: Vec<f64> = Vec::new();
    for place in &edge.uses {
        let (tile, used) = (&tiles[place.tile.index()], place.of(tiles));
        // A use between inner breaks may cover part of a strip.
        if edge.breaks.len() > 2 {
            let ends = [used.from, used.to].map(|at| edge.breaks[at as usize].t);
            let (ends, mut hint) = ([ends[0].min(ends[1]), ends[0].max(ends[1])], used.piece as usize);
            for strip in breaks[last_before(breaks, ends[0])..].windows(2).take_while(|strip| strip[0] < ends[1]) {
                let part = [strip[0].max(ends[0]), strip[1].min(ends[1])];
                if part != strip[..] {
                    let [from, to] = part.map(|t| used.uv.point(t, &mut hint) / (tile.max - tile.min));
                    let crossed = (to - from).abs().max_element();
                    if crossed * (strip[1] - strip[0]) > TILES * (part[1] - part[0]) {
                        cuts.extend(part);
                    }
                }
            }
        }
        let UvCurve::Hermite(samples) = &used.uv else { continue };
        if samples.len() < MANY {
            continue;
        }
        let [from, to] = [samples[0].t, samples[samples.len() - 1].t];
        for w in breaks[last_before(breaks, from)..].windows(2).take_while(|w| w[0] < to) {
            let first = samples.partition_point(|s| s.t <= w[0]);
            let last = samples.partition_point(|s| s.t < w[1]);
            if last >= first + MANY {
                cuts.extend(samples[first..last].iter().map(|s| s.t));
            }
        }
    }
    if cuts.is_empty() {
        return cuts;
    }
    cuts.extend_from_slice(breaks);
    // A stretch of the edge ends at a break, and is sampled up to there.
    cuts.extend(edge.breaks.iter().map(|b| b.t).filter(|&t| t > breaks[0] && t < breaks[breaks.len() - 1]));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    /// An image that crosses its tile once, evenly, asks for as many segments as the lattice has cells.
    #[test]
    fn no_rate_asks_for_more_segments_than_cells() {
        let mut draw = SplitMix(5);
        let widths = [1.0, 3.0, 5.0, 7.0, 10.0, 0.7].into_iter().chain((0..1000).map(|_| draw.range(0.1, 100.0)));
        for width in widths {
            for cells in [1.0, 7.0, 100.0, 4095.0] {
                let segments = f64::from(rounded_down(1.0 / width)) * cells * width;
                assert!(segments <= cells && segments > cells - 1e-2, "{width} {cells}: {segments}");
            }
        }
        assert!(rounded_down(f64::INFINITY).is_finite() && rounded_down(0.0) == 0.0);
    }
}
