//! Tiles dealt once to workers that never talk to each other; one thread commits what they make. See `README.md` here.

pub mod distribute;
