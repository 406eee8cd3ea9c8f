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
    let has_std = if HAS_STD { "on" } else { "off" };
    if let Ok(expected) = std::env::var("IPF_EXPECT_STD") {
        assert_eq!(has_std, expected);
    }
}
