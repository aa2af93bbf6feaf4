#![no_main]
//! campaign.toml, beside a sound design table.

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("campaign.toml"), data).expect("writable");
    std::fs::write(folder.path().join("design.csv"), "run,replicate,stiff,profile\n1,1,-1,a.csv\n2,1,1,b.csv\n").expect("writable");
    let _ = hemline::import::load(folder.path());
});
