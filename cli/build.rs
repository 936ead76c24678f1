//! Linker options of the program.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let target = |of: &str| env::var(format!("CARGO_CFG_TARGET_{of}")).unwrap_or_default();
    if target("OS") == "linux" && target("ENV") == "gnu" {
        // At a fixed address nothing is relocated when the program starts, and no page is copied for that
        // (docs/decisions/068).
        println!("cargo::rustc-link-arg-bins=-no-pie");
    }
}
