#![no_main]
//! Pictures.

mod on_disk;

use hemline::experiment::campaign::{Pictures, Shade};
use hemline::units::Metre;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    on_disk::with_file(data, &["png", "jpg", "tif", "bmp"], |path| {
        let _ = hemline::import::image::outline(path, &Pictures { pixel: Metre(1e-3), object: Shade::Auto });
    });
});
