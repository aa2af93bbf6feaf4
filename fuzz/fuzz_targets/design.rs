#![no_main]
//! The design table, beside a sound campaign.toml.

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("campaign.toml"), include_bytes!("../corpus/campaign/small.toml")).expect("writable");
    std::fs::write(folder.path().join("design.csv"), data).expect("writable");
    let _ = hemline::import::load(folder.path());
});
