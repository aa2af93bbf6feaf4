//! The order of an outline is kept or found, whatever the noise and however it was mixed up.

use std::f64::consts::TAU;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// A hem with folds; a lean of 0.1 m/m² overhangs.
fn hem(n: usize, folds: f64, depth: f64, lean: f64) -> Vec<Point> {
    (0..n)
        .map(|i| {
            let t = TAU * i as f64 / n as f64;
            let (r, across) = (0.2 + depth * (folds * t).cos(), lean * (2.0 * folds * t).sin());
            Point::new(r * t.cos() - across * t.sin(), r * t.sin() + across * t.cos())
        })
        .collect()
}

fn shaken(points: &[Point], sigma: f64, random: &mut ChaCha8Rng) -> Vec<Point> {
    // Twelve uniform numbers: variance one, near enough normal.
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    points.iter().map(|p| Point::new(p.x + sigma * normal(), p.y + sigma * normal())).collect()
}

/// How many neighbours in `order` are neighbours on the ring 0, 1, …, n − 1.
fn right_links(order: &[usize]) -> usize {
    let n = order.len();
    (0..n).filter(|&i| [1, n - 1].contains(&((order[i] + n - order[(i + 1) % n]) % n))).count()
}

/// Shuffles `points` and returns how many links of the found order are links of the ring.
fn restored(points: &[Point], random: &mut ChaCha8Rng) -> usize {
    let mut shuffle: Vec<usize> = (0..points.len()).collect();
    shuffle.shuffle(random);
    let scattered: Vec<Point> = shuffle.iter().map(|&i| points[i]).collect();
    let order = reorder(&scattered).expect("a shuffled outline is not in order");
    right_links(&order.iter().map(|&i| shuffle[i]).collect::<Vec<_>>())
}

#[test]
fn an_outline_is_kept_from_twelve_points_to_a_hundred_thousand() {
    for n in [12, 13, 20, 36, 180, 2000, 100_000] {
        assert_eq!(reorder(&hem(n, 5.0, 0.05, 0.01)), None, "{n} points");
        assert_eq!(reorder(&hem(n, 5.0, 0.0, 0.0)), None, "circle of {n} points");
    }
    assert_eq!(reorder(&hem(180, 8.0, 0.06, 0.03)), None, "overhanging");
}

#[test]
fn scattered_points_get_the_order_round_the_outline_overhangs_included() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for (n, folds, depth, lean) in
        [(24, 3.0, 0.03, 0.0), (180, 5.0, 0.05, 0.01), (360, 8.0, 0.06, 0.03), (720, 7.0, 0.08, 0.04), (4000, 12.0, 0.08, 0.02)]
    {
        for _ in 0..5 {
            assert_eq!(restored(&hem(n, folds, depth, lean), &mut random), n, "{n} points, {folds} folds");
        }
    }
}

#[test]
fn scattered_points_with_digitiser_noise_are_misplaced_by_neighbours_only() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let clean = hem(360, 8.0, 0.06, 0.03);
    // Noise of a fifth of the mean spacing of 8 mm.
    let points = shaken(&clean, 0.0016, &mut random);
    let right = restored(&points, &mut random);
    // Where points crowd at the crests, neighbours change places: a few in a hundred.
    assert!(330 <= right, "{right} of 360 links");
}

#[test]
fn dense_noise_is_seen_through_by_means_and_a_scrambled_curve_is_not_taken_for_it() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    for (n, sigma) in [(20_000, 0.001), (100_000, 0.001), (100_000, 0.0003)] {
        let noisy = shaken(&hem(n, 8.0, 0.06, 0.03), sigma, &mut random);
        assert!(!plainly_in_order(&noisy) && in_order_through_noise(&noisy), "{n} points, noise {sigma} m");
        let mut shuffled = noisy;
        shuffled.shuffle(&mut random);
        assert!(!in_order_through_noise(&shuffled), "{n} points shuffled");
    }
    // Neighbours that have changed places on a clean curve lie on a line, not in a cloud.
    let mut scrambled = hem(20_000, 8.0, 0.06, 0.03);
    scrambled.chunks_mut(16).for_each(|window| window.shuffle(&mut random));
    assert!(!in_order_through_noise(&scrambled));
    // One point out of place is a jump.
    let mut misplaced = shaken(&hem(20_000, 8.0, 0.06, 0.03), 0.001, &mut random);
    misplaced.swap(100, 10_000);
    assert!(!in_order_through_noise(&misplaced));
}

#[test]
fn noise_wider_than_the_spacing_does_not_lose_the_given_order() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for (n, sigma) in [(360, 0.004), (360, 0.012), (2000, 0.002), (2000, 0.01), (20_000, 0.005)] {
        assert_eq!(reorder(&shaken(&hem(n, 5.0, 0.05, 0.01), sigma, &mut random)), None, "{n} points, noise {sigma} m");
    }
}

#[test]
fn a_few_gross_outliers_do_not_lose_the_given_order() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    for sigma in [0.0, 0.0005, 0.004] {
        let mut points = shaken(&hem(180, 5.0, 0.05, 0.01), sigma, &mut random);
        // A lost decimal point, a swapped sign outside the outline, a slip towards the centre.
        points[20] = Point::new(10.0 * points[20].x, points[20].y);
        points[77] = Point::new(-1.7 * points[77].x, -1.4 * points[77].y);
        points[140] = Point::new(0.01, 0.02);
        assert_eq!(reorder(&points), None, "noise {sigma} m");
    }
}

#[test]
fn a_partly_shuffled_outline_is_put_in_order() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for share in [0.02, 0.1, 0.3, 0.6] {
        let points = hem(200, 6.0, 0.05, 0.01);
        let mut shuffle: Vec<usize> = (0..points.len()).collect();
        let mut moved = shuffle.clone();
        moved.shuffle(&mut random);
        moved.truncate((share * points.len() as f64) as usize);
        let mut places = moved.clone();
        places.rotate_left(1);
        for (&to, &from) in places.iter().zip(&moved) {
            shuffle[to] = from;
        }
        let mixed: Vec<Point> = shuffle.iter().map(|&i| points[i]).collect();
        let order = reorder(&mixed).unwrap_or_else(|| panic!("{share} misplaced went unnoticed"));
        assert_eq!(right_links(&order.iter().map(|&i| shuffle[i]).collect::<Vec<_>>()), 200, "{share}");
    }
}

#[test]
fn rows_mixed_up_with_their_neighbours_are_put_in_order() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let points = hem(200, 6.0, 0.05, 0.01);
    let mut shuffle: Vec<usize> = (0..200).collect();
    shuffle.chunks_mut(10).for_each(|rows| rows.shuffle(&mut random));
    let order = reorder(&shuffle.iter().map(|&i| points[i]).collect::<Vec<_>>()).expect("scrambled nearby");
    assert_eq!(right_links(&order.iter().map(|&i| shuffle[i]).collect::<Vec<_>>()), 200);
}

#[test]
fn two_halves_that_both_run_left_to_right_are_joined() {
    let points = hem(180, 5.0, 0.05, 0.01);
    // The upper half as it is, the lower half turned round: as a sheet with two branches has them.
    let halves: Vec<Point> = points[..90].iter().chain(points[90..].iter().rev()).copied().collect();
    let order = reorder(&halves).expect("two branches are not a ring");
    let back: Vec<usize> = order.iter().map(|&i| if i < 90 { i } else { 269 - i }).collect();
    assert_eq!(right_links(&back), 180);
}

#[test]
fn points_of_an_overhanging_hem_sorted_by_angle_are_not_plainly_in_order() {
    let points = hem(360, 8.0, 0.06, 0.03);
    assert_eq!(reorder(&points), None);
    let angle = |i: &usize| points[*i].y.atan2(points[*i].x);
    let mut sorted: Vec<usize> = (0..360).collect();
    sorted.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    assert!(right_links(&sorted) < 300, "the hem does not overhang");
    assert!(!plainly_in_order(&sorted.iter().map(|&i| points[i]).collect::<Vec<_>>()));
}

#[test]
fn what_is_plainly_in_order_is_so_in_both_directions_with_and_without_noise() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    for n in [90, 360, 10_000] {
        let points = hem(n, 5.0, 0.04, 0.005);
        // A sixth of the mean spacing.
        let noisy = shaken(&points, 0.2 / n as f64, &mut random);
        for mut points in [points, noisy] {
            assert!(plainly_in_order(&points), "{n} points");
            points.reverse();
            assert!(plainly_in_order(&points), "{n} points, clockwise");
        }
    }
}

#[test]
fn no_way_to_mix_up_an_outline_is_plainly_in_order() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let points = hem(360, 6.0, 0.05, 0.01);
    let mixed = |order: &[usize]| order.iter().map(|&i| points[i]).collect::<Vec<_>>();
    let ring = || (0..360).collect::<Vec<usize>>();
    // Two points far from each other exchanged; neighbours exchanged all round; a stretch turned round; every second point, then the others.
    for at in 0..300 {
        let mut order = ring();
        order.swap(at, at + 40);
        assert!(!plainly_in_order(&mixed(&order)), "{at}");
        let mut order = ring();
        order[at..at + 60].reverse();
        assert!(!plainly_in_order(&mixed(&order)), "{at} turned round");
    }
    let mut order = ring();
    order.chunks_mut(2).for_each(|pair| pair.reverse());
    assert!(!plainly_in_order(&mixed(&order)));
    order.sort_by_key(|i| (i % 2, *i));
    assert!(!plainly_in_order(&mixed(&order)));
    for block in [3, 5, 20, 360] {
        let mut order = ring();
        order.chunks_mut(block).for_each(|rows| rows.shuffle(&mut random));
        assert!(!plainly_in_order(&mixed(&order)), "blocks of {block}");
    }
}

#[test]
fn a_gap_in_an_outline_is_no_reason_to_reorder_it() {
    let points = hem(360, 5.0, 0.05, 0.01);
    assert_eq!(reorder(&points[..270]), None);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    assert_eq!(reorder(&shaken(&points[60..], 0.006, &mut random)), None);
}

#[test]
fn a_hundred_thousand_scattered_points_are_put_in_order() {
    // Quadratic work would be 1e10 distances; the suite's patience is the measure.
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let clean = hem(100_000, 7.0, 0.06, 0.02);
    assert_eq!(restored(&clean, &mut random), 100_000);
    let noisy = shaken(&clean, 0.0005, &mut random);
    let mut shuffled = noisy.clone();
    shuffled.shuffle(&mut random);
    assert!(reorder(&shuffled).is_some());
}
