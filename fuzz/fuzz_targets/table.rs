#![no_main]
//! Profile tables.

mod on_disk;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    on_disk::with_file(data, &["csv", "tsv", "txt", "gz", "xlsx", "xls", "ods", "parquet", "arrow"], |path| {
        let _ = hemline::import::table::profiles(path);
    });
});
