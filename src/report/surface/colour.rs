//! Colours of a field: a map that colour-blind readers can read, and the legend that goes with it.
//!
//! Colours are laid out in OKLab, where equal steps look equal, and lightness alone orders them: dark is little and light is much; about 0, blue is
//! negative, orange positive, and white nothing. Source of OKLab: Ottosson, A perceptual color space for image processing, 2020.

use crate::error::Error;
use crate::model::field::{Field, SurfaceFields};

/// Linear red, green and blue, 0…1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    pub linear: [f64; 3],
}

impl Colour {
    /// As screens and most files have it: sRGB, 0…1.
    pub fn srgb(self) -> [f64; 3] {
        self.linear.map(|x| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 })
    }

    /// sRGB in 8 bits.
    pub fn bytes(self) -> [u8; 3] {
        self.srgb().map(|x| (255.0 * x).round().clamp(0.0, 255.0) as u8)
    }

    /// From lightness, chroma and hue (degrees) of OKLab; what a screen cannot show is drawn towards grey of the same lightness.
    fn of(lightness: f64, chroma: f64, hue: f64) -> Self {
        let (sin, cos) = hue.to_radians().sin_cos();
        let at = |chroma: f64| {
            let (a, b) = (chroma * cos, chroma * sin);
            let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
            let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
            let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548 * b).powi(3);
            [
                4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
                -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
                -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
            ]
        };
        let shown = |rgb: &[f64; 3]| rgb.iter().all(|x| (-1e-9..=1.0 + 1e-9).contains(x));
        let mut chroma = chroma;
        while !shown(&at(chroma)) && 1e-3 < chroma {
            chroma *= 0.98;
        }
        Colour { linear: at(chroma).map(|x| x.clamp(0.0, 1.0)) }
    }

    /// Of a share 0…1 of the range: from a dark violet over blue and green to a light yellow.
    pub fn sequential(share: f64) -> Self {
        let t = share.clamp(0.0, 1.0);
        Colour::of(0.28 + 0.65 * t, 0.125, 300.0 - 195.0 * t)
    }

    /// Of a share −1…1: blue, white, orange.
    pub fn diverging(share: f64) -> Self {
        let t = share.clamp(-1.0, 1.0);
        Colour::of(0.965 - 0.5 * t.abs(), 0.16 * t.abs(), if t < 0.0 { 255.0 } else { 50.0 })
    }
}

/// A field with its range of colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    pub field: Field,
    /// Values at the ends of the colours.
    pub range: (f64, f64),
    /// For each point of the surface.
    pub values: Vec<f64>,
}

impl Legend {
    /// # Errors
    /// [`Error::Unanswerable`] where the field does not exist; [`Error::Invalid`] for a range of no width.
    pub fn of(surface: &SurfaceFields, field: Field, range: Option<(f64, f64)>) -> Result<Self, Error> {
        let values = surface.values(field).map_err(|reason| Error::Unanswerable(format!("no {}: {reason}", field.name())))?.to_vec();
        if let Some((low, high)) = range
            && !(low.is_finite() && high.is_finite() && low < high)
        {
            return Err(Error::Invalid { quantity: "upper end of the colours", value: high, allowed: "more than the lower end" });
        }
        let own = || {
            let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
            let largest = low.abs().max(high.abs());
            let (low, high) = if field.signed() { (-largest, largest) } else { (low, high) };
            // A field that is the same everywhere has a middle colour.
            if high - low <= 1e-9 * largest || largest == 0.0 { (low - 0.5, high + 0.5) } else { (low, high) }
        };
        let range = range.unwrap_or_else(own);
        Ok(Legend { field, range, values })
    }

    /// The colour of a value.
    pub fn colour(&self, value: f64) -> Colour {
        let (low, high) = self.range;
        let share = (value - low) / (high - low);
        if self.field.signed() { Colour::diverging(2.0 * share - 1.0) } else { Colour::sequential(share) }
    }

    /// The name of the map.
    pub fn map(&self) -> &'static str {
        if self.field.signed() { "diverging: blue, white, orange" } else { "sequential: violet, green, yellow" }
    }

    /// Colours at `n` even places of the range, from low to high, sRGB.
    pub fn scale(&self, n: usize) -> Vec<(f64, [f64; 3])> {
        let (low, high) = self.range;
        (0..n).map(|i| low + (high - low) * i as f64 / (n - 1) as f64).map(|v| (v, self.colour(v).srgb())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance (IEC 61966-2-1).
    fn luminance(c: Colour) -> f64 {
        0.2126 * c.linear[0] + 0.7152 * c.linear[1] + 0.0722 * c.linear[2]
    }

    #[test]
    fn lightness_alone_orders_the_colours() {
        let rises =
            |c: &dyn Fn(f64) -> Colour| (0..256).all(|i| luminance(c(f64::from(i) / 256.0)) < luminance(c(f64::from(i + 1) / 256.0)));
        assert!(rises(&Colour::sequential) && rises(&|t| Colour::diverging(t - 1.0)) && rises(&|t| Colour::diverging(1.0 - t)));
        assert!(luminance(Colour::sequential(0.0)) < 0.05 && 0.7 < luminance(Colour::sequential(1.0)));
    }

    #[test]
    fn deuteranopes_tell_the_two_sides_of_zero_apart() {
        // Without the middle cones: Viénot, Brettel & Mollon, Color Research & Application 24 (1999) 243–252, linear RGB to what a deuteranope sees.
        let seen = |c: Colour| {
            let [r, g, b] = c.linear;
            [0.292_75 * r + 0.707_25 * g, 0.292_75 * r + 0.707_25 * g, -0.022_34 * r + 0.022_34 * g + b]
        };
        for t in [0.3, 0.6, 1.0] {
            let (minus, plus) = (seen(Colour::diverging(-t)), seen(Colour::diverging(t)));
            // Yellow against blue: the difference of both has opposite signs.
            assert!(minus[0] < minus[2] && plus[2] < plus[0], "{t}: {minus:?} {plus:?}");
        }
    }

    #[test]
    fn grey_and_white_are_what_they_are_called() {
        assert_eq!(Colour::of(1.0, 0.0, 0.0).bytes(), [255, 255, 255]);
        let [r, g, b] = Colour::of(0.5, 0.0, 0.0).bytes();
        assert!(r == g && g == b);
    }
}
