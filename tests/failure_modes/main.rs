//! What made other tessellators fail, each with its own smallest input: every case climbs a ladder of tolerances and is
//! checked at each rung ([`ladder`]).
//!
//! The groups are those in which such reports come: faces that are lost, seams and poles, cracks, tolerances not kept,
//! scales, endless inputs, and one bad face that takes others with it.

mod body;
mod borders;
mod cones;
mod fillets;
#[path = "../flipped/mod.rs"]
mod flipped;
mod ladder;
mod noise;
mod scale;
mod seams;
mod splines;
mod topology;
#[cfg(feature = "step")]
mod turned;
