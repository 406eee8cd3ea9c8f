#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| amiro_ipf_fuzz::terminal::check(bytes));
