#![no_main]
//! Tables of numbers.

mod on_disk;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    on_disk::with_file(data, &["csv", "tsv", "txt"], |path| {
        let _ = hemline::import::numbers::NumberTable::read(path);
    });
});
