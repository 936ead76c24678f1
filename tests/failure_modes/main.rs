//! Inputs that made other tessellators fail, each in its smallest form. Every case is meshed at a ladder of tolerances
//! and checked at each ([`ladder`]).
//!
//! Grouped as such reports are: lost faces, seams and poles, cracks, violated tolerances, scales, endless inputs, and
//! one bad face that takes others with it.

mod body;
mod borders;
#[path = "../common/mod.rs"]
mod common;
mod cones;
mod fillets;
#[path = "../flipped/mod.rs"]
mod flipped;
mod ladder;
mod noise;
mod scale;
mod seams;
mod splines;
mod thin;
mod topology;
#[cfg(feature = "step")]
mod turned;
