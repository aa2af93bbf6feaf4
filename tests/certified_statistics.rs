//! The statistics against certified and published numbers. `strd.json` is made by `scripts/strd_fixtures.py` from NIST's data sets.

use hemline::statistics::anova::one_way;
use hemline::statistics::linear_model::{LinearModel, Regressors, ordinary};
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
