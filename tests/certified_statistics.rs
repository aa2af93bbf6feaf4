//! The statistics against certified and published numbers. `strd.json` is made by `scripts/strd_fixtures.py` from NIST's data sets.

use hemline::statistics::anova::one_way;
use hemline::statistics::box_cox::box_cox;
use hemline::statistics::box_wilson::{Analysis, Options, analyse};
use hemline::statistics::distribution;
use hemline::statistics::factorial::{Axis, FactorialDesign};
use hemline::statistics::family::adjust;
use hemline::statistics::linear_model::{LinearModel, Regressors, ordinary, weighted};
use hemline::statistics::permutation::{self, permutation_tests};
use hemline::statistics::power::power;
use hemline::statistics::residuals::{durbin_watson, shapiro_wilk};
use hemline::statistics::sums_of_squares::{Adjustment, factorial_anova};
use serde_json::Value;

fn fixture(name: &str) -> Value {
    let path = format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(&path).unwrap_or_else(|why| panic!("{path}: {why}"))).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_str().unwrap().parse().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn set<'a>(strd: &'a Value, kind: &str, name: &str) -> &'a Value {
    strd[kind].as_array().unwrap().iter().find(|set| set["name"] == name).unwrap()
}

/// Log relative error: the number of digits that agree, 15 at most (the certified values have no more). Absolute where 0 is certified.
fn digits(found: f64, certified: f64) -> f64 {
    if found == certified {
        return 15.0;
    }
    let error = (found - certified).abs() / if certified == 0.0 { 1.0 } else { certified.abs() };
    (-error.log10()).min(15.0)
}

fn fit(set: &Value) -> LinearModel {
    let y = numbers(&set["y"]);
    let x: Vec<Vec<f64>> = set["x"].as_array().unwrap().iter().map(numbers).collect();
    let terms = set["coefficients"].as_array().unwrap().len();
    if set["polynomial"] == true {
        return ordinary(&Regressors::polynomial(&x[0], terms - 1).unwrap(), &y).unwrap();
    }
    let mut names: Vec<String> = (1..=x.len()).map(|i| format!("x{i}")).collect();
    let mut columns = x;
    if set["intercept"] == true {
        names.insert(0, "1".into());
        columns.insert(0, vec![1.0; y.len()]);
    }
    ordinary(&Regressors::new(names, columns).unwrap(), &y).unwrap()
}

/// Least number of certified digits over estimates, standard errors, residual standard deviation, R² and F.
fn linear_digits(name: &str) -> [f64; 5] {
    let strd = fixture("strd.json");
    let set = set(&strd, "linear", name);
    let model = fit(set);
    let certified = set["coefficients"].as_array().unwrap();
    assert_eq!(model.estimates.len(), certified.len(), "{name}: {:?}", model.aliases);
    let least = |digits: Vec<f64>| digits.into_iter().fold(15.0, f64::min);
    let estimates = least(model.estimates.iter().zip(certified).map(|(e, c)| digits(e.estimate, number(&c[0]))).collect());
    let errors = least(model.estimates.iter().zip(certified).map(|(e, c)| digits(e.standard_error.unwrap(), number(&c[1]))).collect());
    let deviation = digits(model.residual_standard_deviation().unwrap(), number(&set["residual_standard_deviation"]));
    let r_squared = digits(model.r_squared().unwrap(), number(&set["r_squared"]));
    let f = match &set["f"] {
        Value::Null => {
            assert_eq!(model.f(), None, "{name} is a perfect fit");
            15.0
        }
        f => digits(model.f().unwrap(), number(f)),
    };
    println!("{name:9} estimates {estimates:5.1}  standard errors {errors:5.1}  deviation {deviation:5.1}  R² {r_squared:5.1}  F {f:5.1}");
    [estimates, errors, deviation, r_squared, f]
}

macro_rules! linear_sets {
    ($($test:ident $name:literal $digits:literal),* $(,)?) => {$(
        #[test]
        fn $test() {
            let found = linear_digits($name);
            assert!(found.iter().all(|digits| *digits >= $digits), "{}: {found:?}", $name);
        }
    )*};
}

linear_sets! {
    nist_norris_agrees_to_twelve_digits "Norris" 12.0,
    nist_pontius_agrees_to_twelve_digits "Pontius" 12.0,
    nist_noint1_agrees_to_twelve_digits "NoInt1" 12.0,
    nist_noint2_agrees_to_twelve_digits "NoInt2" 12.0,
    nist_filip_agrees_to_twelve_digits "Filip" 12.0,
    nist_longley_agrees_to_twelve_digits "Longley" 12.0,
    nist_wampler1_agrees_to_twelve_digits "Wampler1" 12.0,
    nist_wampler2_agrees_to_twelve_digits "Wampler2" 12.0,
    nist_wampler3_agrees_to_twelve_digits "Wampler3" 12.0,
    nist_wampler4_agrees_to_twelve_digits "Wampler4" 12.0,
    nist_wampler5_agrees_to_twelve_digits "Wampler5" 12.0,
}

#[test]
fn filip_with_powers_rounded_to_doubles_keeps_seven_digits() {
    // What a program reaches that forms the powers in doubles and then solves exactly: the rounding of the data alone.
    let strd = fixture("strd.json");
    let set = set(&strd, "linear", "Filip");
    let x = numbers(&set["x"][0]);
    let columns: Vec<Vec<f64>> = (0..11).map(|power| x.iter().map(|x| x.powi(power)).collect()).collect();
    let names = (0..11).map(|power| format!("x^{power}")).collect();
    let model = ordinary(&Regressors::new(names, columns).unwrap(), &numbers(&set["y"])).unwrap();
    let certified = set["coefficients"].as_array().unwrap();
    let least = model.estimates.iter().zip(certified).map(|(e, c)| digits(e.estimate, number(&c[0]))).fold(15.0, f64::min);
    println!("Filip with rounded powers: {least:.1} digits");
    assert!(least >= 7.0);
}

/// The groups as the published decimal strings, each rounded once to a double.
fn groups(set: &Value) -> Vec<Vec<f64>> {
    if let Some(groups) = set.get("groups") {
        return groups.as_array().unwrap().iter().map(numbers).collect();
    }
    // Simon & Lesage: a level, then alternately 0.1 below and above it, all on top of the offset.
    let offset = set["offset"].as_str().unwrap();
    let tenths = |level: &Value| level.as_str().unwrap().strip_prefix("0.").unwrap().parse::<u32>().unwrap();
    let replicates = set["replicates"].as_u64().unwrap();
    let levels = set["levels"].as_array().unwrap();
    let one = |level: u32, i: u64| match i {
        0 => level,
        i if i % 2 == 0 => level + 1,
        _ => level - 1,
    };
    levels.iter().map(|level| (0..replicates).map(|i| format!("{offset}.{}", one(tenths(level), i)).parse().unwrap()).collect()).collect()
}

fn anova_digits(name: &str) -> f64 {
    let strd = fixture("strd.json");
    let set = set(&strd, "anova", name);
    let found = one_way(&groups(set)).unwrap();
    assert_eq!((found.between_df as f64, found.within_df as f64), (number(&set["between_df"]), number(&set["within_df"])));
    let all = [
        digits(found.between_sum_of_squares, number(&set["between_sum_of_squares"])),
        digits(found.within_sum_of_squares, number(&set["within_sum_of_squares"])),
        digits(found.f.unwrap(), number(&set["f"])),
        digits(found.r_squared.unwrap(), number(&set["r_squared"])),
    ];
    // The doubles nearest to the decimals hold these sums exactly (rational arithmetic): what is missing to the certified digits is lost in
    // reading, none of it in computing.
    let rounded = floats(&set["rounded"]);
    assert!(digits(found.between_sum_of_squares, rounded[0]) >= 14.5 && digits(found.within_sum_of_squares, rounded[1]) >= 14.5, "{name}");
    println!("{name:8} between {:5.1}  within {:5.1}  F {:5.1}  R² {:5.1}", all[0], all[1], all[2], all[3]);
    all.into_iter().fold(15.0, f64::min)
}

macro_rules! anova_sets {
    ($($test:ident $name:literal $digits:literal),* $(,)?) => {$(
        #[test]
        fn $test() {
            let found = anova_digits($name);
            assert!(found >= $digits, "{}: {found}", $name);
        }
    )*};
}

anova_sets! {
    nist_atmwtag_agrees_to_nine_digits "AtmWtAg" 9.0,
    nist_sirstv_agrees_to_twelve_digits "SiRstv" 12.0,
    nist_smls01_agrees_to_thirteen_digits "SmLs01" 13.0,
    nist_smls02_agrees_to_thirteen_digits "SmLs02" 13.0,
    nist_smls03_agrees_to_thirteen_digits "SmLs03" 13.0,
    nist_smls04_agrees_to_nine_digits "SmLs04" 9.0,
    nist_smls05_agrees_to_nine_digits "SmLs05" 9.0,
    nist_smls06_agrees_to_nine_digits "SmLs06" 9.0,
    nist_smls07_agrees_to_three_digits "SmLs07" 3.0,
    nist_smls08_agrees_to_three_digits "SmLs08" 3.0,
    nist_smls09_agrees_to_three_digits "SmLs09" 3.0,
}

// ---- Factorial designs against statsmodels; `statistics_reference.json` is made by `scripts/statistics_reference.py`. ----

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(floats).collect()
}

fn reference() -> Value {
    fixture("statistics_reference.json")
}

/// Relative to the larger of the reference and `scale`; 1e-9 is what a double-precision reference of these designs is worth.
fn close(found: f64, reference: f64, scale: f64) -> bool {
    (found - reference).abs() <= 1e-9 * reference.abs().max(scale)
}

fn design_of(levels: Vec<Vec<f64>>) -> FactorialDesign {
    let factors = (0..levels[0].len()).map(|i| Axis::coded(["a", "b", "c", "d", "e", "f"][i])).collect();
    FactorialDesign::new(factors, levels).unwrap()
}

fn analysis_of(case: &Value) -> Analysis {
    let y: Vec<Option<f64>> = floats(&case["y"]).into_iter().map(Some).collect();
    analyse(&design_of(rows(&case["levels"])), &y, &Options::default()).unwrap()
}

fn each_design(check: impl Fn(&str, &Value, Analysis)) {
    for case in reference()["designs"].as_array().unwrap() {
        check(case["label"].as_str().unwrap(), case, analysis_of(case));
    }
}

#[test]
fn coefficients_errors_and_tests_agree_with_statsmodels() {
    each_design(|label, case, found| {
        let (estimate, se, t, p, ci) =
            (floats(&case["estimate"]), floats(&case["se"]), floats(&case["t"]), floats(&case["p"]), rows(&case["ci"]));
        let deviation = found.error.unwrap().variance.sqrt();
        for (j, c) in found.coefficients.iter().enumerate() {
            assert_eq!(c.term, case["terms"][j].as_str().unwrap(), "{label}");
            assert!(close(c.estimate, estimate[j], deviation), "{label} {}: {} vs {}", c.term, c.estimate, estimate[j]);
            assert!(close(c.se.unwrap(), se[j], 0.0) && close(c.t.unwrap(), t[j], 1.0), "{label} {}", c.term);
            // A tail probability magnifies a relative error of t by about t² where it is small.
            assert!((c.p.unwrap() - p[j]).abs() <= 1e-9 * p[j] * (1.0 + t[j] * t[j]).max(1.0), "{label} {}: {:?} vs {}", c.term, c.p, p[j]);
            assert!(close(c.ci_low.unwrap(), ci[j][0], deviation) && close(c.ci_high.unwrap(), ci[j][1], deviation), "{label} {}", c.term);
        }
        assert_eq!(found.residual_df as f64, case["residual_df"].as_f64().unwrap(), "{label}");
        let significant: Vec<&str> = found.coefficients.iter().filter(|c| c.significant).map(|c| c.term.as_str()).collect();
        assert_eq!(serde_json::json!(significant), case["significant"], "{label}");
    });
}

#[test]
fn influence_and_prediction_agree_with_statsmodels() {
    each_design(|label, case, found| {
        let model = &found.full;
        assert!(close(model.r_squared().unwrap(), case["r_squared"].as_f64().unwrap(), 0.0), "{label}");
        assert!(close(model.adjusted_r_squared().unwrap(), case["adjusted_r_squared"].as_f64().unwrap(), 0.0), "{label}");
        assert!(close(model.f().unwrap(), case["f"].as_f64().unwrap(), 0.0), "{label}");
        let (leverage, deleted) = (floats(&case["leverage"]), model.deleted_residuals());
        let (standardized, cook) = (model.standardized_residuals(), model.cook_distances());
        let mut alone = 0;
        for (run, &h) in leverage.iter().enumerate() {
            assert!(close(model.leverage[run], h, 1.0), "{label} run {run}");
            if h > 1.0 - 1e-9 {
                // statsmodels divides rounding by rounding here; there is nothing to standardize.
                assert_eq!((standardized[run], deleted[run], cook[run]), (None, None, None), "{label} run {run}");
                alone += 1;
                continue;
            }
            assert!(close(standardized[run].unwrap(), case["standardized"][run].as_f64().unwrap(), 1.0), "{label} run {run}");
            assert!(close(deleted[run].unwrap(), case["deleted"][run].as_f64().unwrap(), 1.0), "{label} run {run}");
            assert!(close(cook[run].unwrap(), case["cook"][run].as_f64().unwrap(), 1.0), "{label} run {run}");
        }
        if alone == 0 {
            assert!(close(model.press().unwrap(), case["press"].as_f64().unwrap(), 0.0), "{label}");
        } else {
            assert_eq!(model.press(), None, "{label}");
        }
    });
}

#[test]
fn adequacy_agrees_with_statsmodels_and_with_its_own_anova() {
    let mut tested = 0;
    each_design(|label, case, found| {
        let Some(reference) = case.get("adequacy") else { return assert_eq!(found.adequacy, None, "{label}") };
        let verdict = found.adequacy.unwrap();
        assert!(close(verdict.statistic, reference["f"].as_f64().unwrap(), 0.0), "{label}");
        assert!(close(verdict.p.unwrap(), reference["p"].as_f64().unwrap(), 0.0), "{label}");
        assert_eq!(vec![verdict.df.0, verdict.df.1], floats(&reference["df"]), "{label}");
        // Distances from the cell means here, difference of two residual sums of squares there.
        let split = found.reduced.lack_of_fit.unwrap().f().unwrap();
        assert!((split / verdict.statistic - 1.0).abs() < 1e-10, "{label}: {split} vs {}", verdict.statistic);
    });
    for case in reference()["designs"].as_array().unwrap() {
        tested += usize::from(case.get("adequacy").is_some());
    }
    assert!(tested >= 5, "only {tested} designs leave degrees of freedom for adequacy");
}

#[test]
fn equality_of_variances_agrees_with_numpy_and_scipy() {
    each_design(|label, case, found| {
        let verdict = found.equal_variances.unwrap();
        if let Some(g) = case.get("cochran") {
            assert_eq!(verdict.test, "Cochran G", "{label}");
            assert!(close(verdict.statistic, g.as_f64().unwrap(), 0.0), "{label}");
        } else {
            assert_eq!(verdict.test, "Brown–Forsythe F", "{label}");
            let reference = floats(&case["brown_forsythe"]);
            assert!(close(verdict.statistic, reference[0], 0.0) && close(verdict.p.unwrap(), reference[1], 0.0), "{label}");
        }
    });
}

#[test]
fn family_adjustments_agree_with_statsmodels() {
    each_design(|label, case, found| {
        let mut analyses = [found];
        adjust(&mut analyses);
        for (j, c) in analyses[0].coefficients.iter().enumerate() {
            let t = c.t.unwrap();
            let tolerance = 1e-9 * (1.0 + t * t);
            for (found, reference) in [(c.p_holm, &case["holm"][j]), (c.p_benjamini_hochberg, &case["benjamini_hochberg"][j])] {
                let reference = reference.as_f64().unwrap();
                assert!((found.unwrap() - reference).abs() <= tolerance * reference, "{label} {}: {found:?} vs {reference}", c.term);
            }
        }
    });
}

#[test]
fn weighted_least_squares_agrees_with_statsmodels() {
    let reference = reference();
    let case = &reference["weighted"];
    let x = rows(&case["x"]);
    let y = floats(&case["y"]);
    let names = ["1", "x1", "x2", "x3"].map(String::from).to_vec();
    let columns: Vec<Vec<f64>> = std::iter::once(vec![1.0; y.len()]).chain(x).collect();
    let model = weighted(&Regressors::new(names, columns).unwrap(), &y, &floats(&case["weights"])).unwrap();
    for (j, estimate) in model.estimates.iter().enumerate() {
        assert!(close(estimate.estimate, case["estimate"][j].as_f64().unwrap(), 1.0));
        assert!(close(estimate.standard_error.unwrap(), case["se"][j].as_f64().unwrap(), 0.0));
        assert!((estimate.p.unwrap() / case["p"][j].as_f64().unwrap() - 1.0).abs() < 1e-9 * (1.0 + estimate.t.unwrap().powi(2)));
    }
    assert!(close(model.r_squared().unwrap(), case["r_squared"].as_f64().unwrap(), 0.0));
    assert!(close(model.residual_sum_of_squares, case["residual_sum_of_squares"].as_f64().unwrap(), 0.0));
}

/// Worst relative error of a tail over the fixture's points, and where.
fn worst(points: &Value, tail: impl Fn(&[f64]) -> f64) -> (f64, Vec<f64>) {
    let mut worst = (0.0, Vec::new());
    for point in rows(points) {
        let (arguments, exact) = (&point[..point.len() - 1], point[point.len() - 1]);
        let error = (tail(arguments) / exact - 1.0).abs();
        if error > worst.0 {
            worst = (error, point.clone());
        }
    }
    worst
}

#[test]
fn tails_agree_with_fifty_digit_arithmetic() {
    let reference = reference();
    let tails = &reference["tails"];
    let found = [
        ("student", worst(&tails["student"], |x| distribution::student_two_sided(x[0], x[1]))),
        ("fisher", worst(&tails["fisher"], |x| distribution::fisher_upper(x[0], x[1], x[2]))),
        ("chi squared", worst(&tails["chi_squared"], |x| distribution::chi_squared_upper(x[0], x[1]))),
        ("normal", worst(&tails["normal"], |x| distribution::normal_upper(x[0]))),
    ];
    for (name, (error, place)) in &found {
        println!("{name}: worst relative error {error:.1e} at {place:?}");
    }
    let mut up_to_ten_thousand = tails["student"].clone();
    up_to_ten_thousand.as_array_mut().unwrap().retain(|point| point[1].as_f64().unwrap() <= 1e4);
    let (error, place) = worst(&up_to_ten_thousand, |x| distribution::student_two_sided(x[0], x[1]));
    println!("student up to 1e4 degrees of freedom: {error:.1e} at {place:?}");
    assert!(error < 1e-12);
    // The exponent of a tail of 1e-290 is 670: its rounding alone is 670 ε = 1.5e-13. With ν degrees of freedom the continued fraction
    // starts from a difference of two numbers that agree to 1/ν; here ν ≤ 1e5, and ν ε = 2e-11.
    assert!(found[0].1.0 < 2e-11 && found[1..].iter().all(|(_, (error, _))| *error < 1e-12), "{found:?}");
}

#[test]
fn sums_of_squares_of_all_types_agree_with_statsmodels() {
    for case in reference()["anova"].as_array().unwrap() {
        let (design, y) = (design_of(rows(&case["levels"])), floats(&case["y"]));
        for (name, adjustment) in [("type1", Adjustment::Sequential), ("type2", Adjustment::Hierarchical), ("type3", Adjustment::Partial)] {
            let found = factorial_anova(&design, &y, adjustment).unwrap();
            let exact = rows(&case[name]);
            let total: f64 = exact.iter().map(|row| row[0]).sum();
            for (row, exact) in found.iter().zip(&exact) {
                assert!(close(row.sum_of_squares, exact[0], total), "{name} {}: {} vs {}", row.source, row.sum_of_squares, exact[0]);
                assert!(close(row.f.unwrap(), exact[1], 1.0), "{name} {}", row.source);
                assert!((row.p.unwrap() - exact[2]).abs() <= 1e-9 * exact[2] * (1.0 + exact[1]), "{name} {}", row.source);
            }
            assert_eq!(found.len(), 8);
        }
    }
}

#[test]
fn shapiro_wilk_agrees_with_scipy() {
    // The weights are normal quantiles; SciPy's, after AS R94, are good to seven digits each, which averages to 1e-9 in W. p magnifies that by
    // d ln p / d ln(1 − W), some tens.
    for case in reference()["shapiro"].as_array().unwrap() {
        let values = floats(&case["x"]);
        let found = shapiro_wilk(&values).unwrap();
        let (w, p) = (case["w"].as_f64().unwrap(), case["p"].as_f64().unwrap());
        println!("n = {}: W off by {:.1e}, p by {:.1e}", values.len(), found.w / w - 1.0, found.p / p - 1.0);
        assert!((found.w / w - 1.0).abs() < 1e-8 && (found.p / p - 1.0).abs() < 1e-6, "n = {}", values.len());
    }
}

#[test]
fn durbin_watson_agrees_with_statsmodels() {
    each_design(|label, case, found| {
        assert!(close(durbin_watson(&found.full.residuals).unwrap(), case["durbin_watson"].as_f64().unwrap(), 0.0), "{label}");
    });
}

#[test]
fn box_cox_agrees_with_a_direct_maximization() {
    let reference = reference();
    let case = &reference["box_cox"];
    let y: Vec<Option<f64>> = floats(&case["y"]).into_iter().map(Some).collect();
    let found = box_cox(&design_of(rows(&case["levels"])), &y, 0.05).unwrap().unwrap();
    // The top of a parabola is known to the root of the rounding error only, about 1e-7; its crossings to the rounding error.
    assert!((found.lambda - case["lambda"].as_f64().unwrap()).abs() < 1e-6);
    assert!((found.low.unwrap() - case["low"].as_f64().unwrap()).abs() < 1e-9);
    assert!((found.high.unwrap() - case["high"].as_f64().unwrap()).abs() < 1e-9);
}

#[test]
fn power_agrees_with_thirty_digit_integration() {
    for case in reference()["power"].as_array().unwrap() {
        let case = floats(case);
        assert!((power(case[1], case[0], 0.05) - case[2]).abs() < 1e-12, "{case:?}: {}", power(case[1], case[0], 0.05));
    }
}

#[test]
fn the_exact_permutation_test_of_two_groups_counts_every_arrangement() {
    let reference = reference();
    let case = &reference["permutation"];
    let (low, high) = (floats(&case["low"]), floats(&case["high"]));
    let levels = low.iter().map(|_| vec![-1.0]).chain(high.iter().map(|_| vec![1.0])).collect();
    let y: Vec<Option<f64>> = low.into_iter().chain(high).map(Some).collect();
    let found = permutation_tests(&design_of(levels), &y, &permutation::Options::default()).unwrap();
    assert_eq!((found[0].arrangements, found[0].p_standard_error), (252, None));
    assert!((found[0].p - case["p"].as_f64().unwrap()).abs() < 1e-15);
    // Drawn instead of enumerated, the same p within four of its own standard errors.
    let drawn = permutation_tests(&design_of(rows_of_two(5)), &y, &permutation::Options { most_exact: 0, ..Default::default() }).unwrap();
    assert!((drawn[0].p - found[0].p).abs() < 4.0 * drawn[0].p_standard_error.unwrap());
}

fn rows_of_two(each: usize) -> Vec<Vec<f64>> {
    (0..2 * each).map(|run| vec![if run < each { -1.0 } else { 1.0 }]).collect()
}
