//! Every STEP file of the corpus beside the checkout. Skipped, with a message, where the corpus is absent.
#![cfg(feature = "step")]

mod mesh;
mod read;
mod reference;
