//! The feature `std` is on or off as asked, not as some other crate wishes.

use amiro_ipf::HAS_STD;

#[test]
fn the_library_has_the_features_of_this_test() {
    assert_eq!(HAS_STD, cfg!(feature = "std"));
}

/// A dev-dependency that asked for default features would turn `std` back on in a
/// build without them. The check script says what it expects in `IPF_EXPECT_STD`.
#[test]
fn the_feature_std_is_as_the_caller_expects() {
    match std::env::var("IPF_EXPECT_STD").as_deref() {
        Ok("on") => assert!(HAS_STD),
        Ok("off") => assert!(!HAS_STD),
        _ => {}
    }
}
