//! overfall
fn main() {}
