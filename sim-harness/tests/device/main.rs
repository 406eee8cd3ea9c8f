//! A board, simulated, in QEMU or at the other end of a line.

#[path = "../common/mod.rs"]
mod common;

mod boot_loader;
mod buses;
mod fault_language;
mod fault_words;
mod i2c_master;
mod i2c_model;
mod image;
mod link;
mod link_stress;
mod qemu;
mod robot;
mod soak;
mod supervision;

/// The harness asks for the core without `std`: it is on only where the core is tested too.
#[test]
fn the_feature_std_is_as_the_caller_expects() {
    let has_std = if amiro_ipf::HAS_STD { "on" } else { "off" };
    if let Ok(expected) = std::env::var("IPF_EXPECT_STD") {
        assert_eq!(has_std, expected);
    }
}
