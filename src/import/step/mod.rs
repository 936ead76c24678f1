//! STEP (ISO 10303-21) to a model.
