//! Numbers and signs.
