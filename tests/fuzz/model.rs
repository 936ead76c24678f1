//! Bytes -> models stated by hand: solids of closed forms, and sheets with random nets and loops.

use crate::draw::below;
use crate::sheet::Sheet;
use crate::solid::Solid;
use crate::watch::{self, Case};
use arbitrary::{Result, Unstructured};
use std::time::Duration;

impl Case for Solid {
    fn draw(u: &mut Unstructured<'_>) -> Result<Self> {
        Self::draw(u)
    }

    fn judge(&self) -> std::result::Result<(), String> {
        self.judge()
    }

    fn as_test(&self) -> String {
        format!("#[test]\nfn NAME() {{\n    sound(&{self:?});\n}}")
    }
}

impl Case for Sheet {
    fn draw(u: &mut Unstructured<'_>) -> Result<Self> {
        let wild = below(u, 3)? == 0;
        Self::draw(u, wild)
    }

    fn judge(&self) -> std::result::Result<(), String> {
        self.judge()
    }

    fn as_test(&self) -> String {
        format!("#[test]\nfn NAME() {{\n    sound(&{self:?});\n}}")
    }
}

#[test]
fn model_solids() {
    let target = bolero::check!().with_test_time(Duration::from_secs(1)).with_shrink_time(Duration::from_secs(20));
    target.with_max_len(256).for_each(|bytes: &[u8]| watch::drawn::<Solid>(bytes));
}

#[test]
fn model_sheets() {
    let target = bolero::check!().with_test_time(Duration::from_secs(1)).with_shrink_time(Duration::from_secs(20));
    target.with_max_len(1024).for_each(|bytes: &[u8]| watch::drawn::<Sheet>(bytes));
}
