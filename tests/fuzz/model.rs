//! Bytes -> hand-stated models: solids with closed forms, and sheets with random nets and loops.

use crate::draw::below;
use crate::sequence::judge;
use crate::sheet::Sheet;
use crate::solid::Solid;
use crate::watch::{self, Case};
use arbitrary::{Result, Unstructured};

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
    judge!(100, 256, |bytes: &[u8]| watch::drawn::<Solid>(bytes));
}

#[test]
fn model_sheets() {
    judge!(24, 1024, |bytes: &[u8]| watch::drawn::<Sheet>(bytes));
}
