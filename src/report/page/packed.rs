//! Curves as short lists of whole numbers: differences of rounded values, which the script adds up again.

use crate::experiment::Point;

/// `values` in whole steps, each less the one `width` places before it: interleaved coordinates stay with their own kind.
pub fn packed(values: impl IntoIterator<Item = f64>, width: usize, step: f64) -> Vec<i64> {
    let whole: Vec<i64> = values.into_iter().map(|value| (value / step).round() as i64).collect();
    whole.iter().enumerate().map(|(i, value)| value - if i < width { 0 } else { whole[i - width] }).collect()
}

/// x and y of points, m, in steps of `step` m.
pub fn points<'a>(points: impl IntoIterator<Item = &'a Point>, step: f64) -> Vec<i64> {
    packed(points.into_iter().flat_map(|p| [p.x, p.y]), 2, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_differences_are_the_rounded_values() {
        let values = [1.004, -2.0, 0.996, 7.5, 3.25, -0.004];
        let packed = packed(values, 2, 0.01);
        let mut sums = packed.clone();
        (2..sums.len()).for_each(|i| sums[i] += sums[i - 2]);
        assert_eq!(sums, [100, -200, 100, 750, 325, 0]);
        assert_eq!(packed[2], 0);
    }
}
