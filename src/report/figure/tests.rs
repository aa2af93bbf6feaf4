//! What holds for every figure, on the sample campaign.

use super::*;
use crate::report::{raster, sample};
use crate::units::MILLIMETRE;

/// Every figure of the house, by name.
fn all() -> Vec<(String, String)> {
    let study = sample::study();
    let factors = sample::factors();
    let coefficients = sample::coefficients();
    let mut figures = vec![("symbols".to_string(), symbols::draw().unwrap())];
    for run in study.runs.iter().take(5) {
        let (Some(view), Ok(fit)) = (hem::View::of(run), &run.fit) else { continue };
        figures.push((format!("hem_{}", view.run), hem::draw(&view).unwrap()));
        let outline = run.profile.as_ref().unwrap().points();
        figures.push((format!("distance_{}", view.run), distance::draw(&view.run, outline, &fit.distances, fit.rms).unwrap()));
    }
    let mut rows: Vec<multiples::Row> = vec![];
    for cell in 0..8 {
        let signs = [cell & 1, cell >> 1 & 1, cell >> 2 & 1].map(|bit| 2.0 * f64::from(bit) - 1.0);
        let name = factors.iter().zip(signs).map(|(f, s)| format!("{} {}", f.name, main_effects::level_name(f, s))).collect();
        let hems = study.runs.iter().filter(|r| r.run.levels == signs).filter_map(|r| {
            let view = hem::View::of(r)?;
            let caption = format!("run {} · m 5 · rms 3.2 mm", view.run);
            Some((view, caption))
        });
        rows.push(multiples::Row { name, hems: hems.collect() });
    }
    for page in 1..=multiples::pages(&rows) {
        figures.push((format!("multiples_{page}"), multiples::draw(&rows, page).unwrap().unwrap()));
    }
    figures.push(("pareto".into(), pareto::draw("Mean radius p", 39, &coefficients, 2.0369, 0.05).unwrap()));
    figures.push(("main_effects".into(), main_effects::draw("Mean radius p", "mm", 39, &factors, &coefficients).unwrap()));
    figures.push(("interactions".into(), interactions::draw("Mean radius p", "mm", 39, &factors, &coefficients).unwrap()));
    figures.push(("cube".into(), cube::draw("Mean radius p", "mm", 39, &factors, &coefficients).unwrap().unwrap()));
    let scores: Vec<_> = coefficients[1..]
        .iter()
        .enumerate()
        .map(|(i, c)| half_normal::Score { term: c.term.clone(), magnitude: c.estimate.abs(), quantile: 0.25 * (i as f64 + 0.5) })
        .collect();
    figures.push(("half_normal".into(), half_normal::draw("Mean radius p", "mm", 8, &scores, Some(3.1)).unwrap()));
    let residuals: Vec<_> = (0..39)
        .map(f64::from)
        .map(|i| residuals::Residual {
            run: format!("{}", i + 1.0),
            fitted: 150.0 + (i % 8.0) * 4.0,
            residual: 5.0 * (i * 2.3).sin(),
            normal_quantile: Some((i - 19.0) / 10.0),
        })
        .collect();
    figures.push(("residuals".into(), residuals::draw("Mean radius p", "mm", &residuals).unwrap()));
    let (mut radius, mut depth, mut folds, mut gaps) = (vec![], vec![], vec![], vec![]);
    for run in &study.runs {
        let (Ok(fit), Some(comparison), Some(prediction)) = (&run.fit, &run.comparison, &run.prediction) else { continue };
        let id = run.run.id.clone();
        let mean = (fit.area / std::f64::consts::PI).sqrt();
        let pair = |fitted: f64, predicted: f64| agreement::Pair { run: id.clone(), fitted, predicted };
        radius.push(pair(mean / MILLIMETRE, (mean + comparison.mean_radius) / MILLIMETRE));
        depth.push(pair(fit.fold_depth / MILLIMETRE, (fit.fold_depth + comparison.depth) / MILLIMETRE));
        folds.push(pair(f64::from(fit.folds.unwrap()), f64::from(prediction.folds)));
        let mm = |v: f64| v / MILLIMETRE;
        gaps.push(gap::Gap {
            run: id.clone(),
            cell: gaps.len() / 5,
            rms: mm(comparison.rms),
            mean_radius: mm(comparison.mean_radius),
            depth: mm(comparison.depth),
            fit_rms: mm(fit.rms),
        });
    }
    figures.push(("agreement".into(), agreement::draw(&radius, &depth, &folds).unwrap()));
    figures.push(("gap".into(), gap::draw(&gaps, [12.0, -9.0, 11.0]).unwrap()));
    figures
}

#[test]
fn every_figure_is_an_svg_in_the_embedded_font_and_without_numbers_that_do_not_exist() {
    for (name, svg) in all() {
        sample::look(&format!("figures/{name}.svg"), svg.as_bytes());
        sample::look(&format!("figures/{name}.png"), &raster::png(&name, &svg).unwrap());
        assert!(svg.starts_with("<svg width=\"") && svg.trim_end().ends_with("</svg>"), "{name}");
        assert!(svg.contains("mm\" viewBox"), "{name} has no size on paper");
        assert!(svg.contains("font-family=\"DejaVu Sans\""), "{name}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    }
}

#[test]
fn the_same_data_gives_the_same_figures() {
    assert_eq!(all(), all());
}

#[test]
fn equal_lengths_look_equal_both_ways_in_the_hem_figure() {
    // The mean circle of a round hem must come out as wide as high: compare the extent of the fitted line in grid steps.
    let study = sample::study();
    let mut view = hem::View::of(&study.runs[0]).unwrap();
    let radius = 0.15;
    let at = |i: usize| std::f64::consts::TAU * i as f64 / 400.0;
    view.fitted = (0..400)
        .map(|i| crate::experiment::Point::new(view.centre.x + radius * at(i).cos(), view.centre.y + radius * at(i).sin()))
        .collect();
    let svg = hem::draw(&view).unwrap();
    let line = svg.lines().find(|l| l.starts_with("<path fill=\"none\"") && l.contains("#0072B2")).unwrap();
    let path = line.split(" d=\"").nth(1).unwrap().trim_end_matches("\"/>");
    let points = drawing::pieces(path).swap_remove(0);
    assert!(200 < points.len(), "no curve");
    let extent = |pick: fn(&(f64, f64)) -> f64| {
        let all = points.iter().map(pick);
        all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
    };
    // Four roundings to whole grid steps.
    assert!((extent(|p| p.0) - extent(|p| p.1)).abs() <= 4.0);
}

/// A full model in `k` factors without standard errors.
fn bare(k: usize) -> (Vec<crate::experiment::Factor>, Vec<crate::statistics::box_wilson::Coefficient>) {
    let names = ["rigidity", "density", "conicity", "humidity", "temperature"];
    let factor =
        |name: &&str| crate::experiment::Factor { name: name.to_string(), label: name.to_string(), unit: None, low: 1.0, high: 2.0 };
    let coefficient = |subset: usize| crate::statistics::box_wilson::Coefficient {
        term: match subset {
            0 => "1".into(),
            _ => (0..k).filter(|i| subset >> i & 1 == 1).map(|i| names[i]).collect::<Vec<_>>().join(":"),
        },
        estimate: 10.0 / (1.0 + subset as f64),
        se: None,
        t: None,
        p: None,
        ci_low: None,
        ci_high: None,
        p_holm: None,
        p_benjamini_hochberg: None,
        significant: false,
    };
    (names[..k].iter().map(factor).collect(), (0..1 << k).map(coefficient).collect())
}

#[test]
fn designs_of_one_to_five_factors_without_replicates_are_drawn() {
    for k in 1..=5 {
        let (factors, coefficients) = bare(k);
        let main = main_effects::draw("Fold depth", "mm", 8, &factors, &coefficients).unwrap();
        sample::look(&format!("figures/bare_main_{k}.png"), &raster::png("main", &main).unwrap());
        let interactions = interactions::draw("Fold depth", "mm", 8, &factors, &coefficients).unwrap();
        sample::look(&format!("figures/bare_interactions_{k}.png"), &raster::png("interactions", &interactions).unwrap());
        assert!(!main.contains("NaN") && !interactions.contains("NaN"));
        assert_eq!(cube::draw("Fold depth", "mm", 8, &factors, &coefficients).unwrap().is_some(), (2..=3).contains(&k));
        // Nothing has a t: the chart is empty, not broken.
        assert!(!pareto::draw("Fold depth", 8, &coefficients, 2.0, 0.05).unwrap().contains("NaN"));
    }
}

#[test]
fn constant_and_empty_data_are_drawn() {
    let same = |run: &str| residuals::Residual { run: run.into(), fitted: 3.0, residual: 0.0, normal_quantile: None };
    assert!(!residuals::draw("Fold count m", "", &[same("1"), same("2")]).unwrap().contains("NaN"));
    assert!(!residuals::draw("Fold count m", "", &[]).unwrap().contains("NaN"));
    assert!(!agreement::draw(&[], &[], &[]).unwrap().contains("NaN"));
    assert!(multiples::pages(&[]) == 0 && multiples::draw(&[], 1).unwrap().is_none());
    assert!(!half_normal::draw("s", "mm", 8, &[], None).unwrap().contains("NaN"));
}
