#![no_main]
//! Pictures.

mod on_disk;

use hemline::experiment::campaign::{PictureScale, Pictures};
use hemline::units::Metre;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    on_disk::with_file(data, &["png", "jpg", "tif", "bmp"], |path| {
        let _ = hemline::import::image::outline(path, &Pictures::of_scale(PictureScale::Pixel(Metre(1e-3))));
    });
});
