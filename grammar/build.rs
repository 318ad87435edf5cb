//! Gives the path of `scn.pest` to the build script of the package that generates a reader from it.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let folder = env::var("CARGO_MANIFEST_DIR").expect("Cargo sets the folder of the package");
    println!("cargo::metadata=text={folder}/scn.pest");
}
