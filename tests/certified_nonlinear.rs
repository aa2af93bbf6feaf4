//! The least-squares engine against NIST's certified nonlinear regressions, and against problems of the same forms with generated data.
//!
//! `strd_nonlinear.json` is made by `scripts/strd_fixtures.py`. Every problem is solved from both of NIST's starts, with derivatives exact to
//! rounding (dual numbers) and with numeric ones.

use std::cell::Cell;

use hemline::numerics::dual::Dual;
use hemline::numerics::least_squares::{FitOptions, fit, fit_with_jacobian};
use serde_json::Value;

/// Parameters of the largest problem.
const MOST: usize = 9;

fn exp<const N: usize>(z: Dual<N>) -> Dual<N> {
    let value = z.value.exp();
    z.chain(value, value)
}

fn power<const N: usize>(z: Dual<N>, exponent: Dual<N>) -> Dual<N> {
    exp(ln(z) * exponent)
}

fn ln<const N: usize>(z: Dual<N>) -> Dual<N> {
    z.chain(z.value.ln(), 1.0 / z.value)
}

fn arctan<const N: usize>(z: Dual<N>) -> Dual<N> {
    z.chain(z.value.atan(), 1.0 / (1.0 + z.value * z.value))
}

/// The models as NIST writes them, by the name of a data set.
fn model<const N: usize>(name: &str, b: &[Dual<N>], x: &[f64]) -> Dual<N> {
    let number = Dual::<N>::constant;
    let x1 = x[0];
    match name {
        "Misra1a" | "BoxBOD" => b[0] * (number(1.0) - exp(b[1] * -x1)),
        "Misra1b" => b[0] * (number(1.0) - (b[1] * (0.5 * x1) + 1.0).square().recip()),
        "Misra1c" => b[0] * (number(1.0) - (b[1] * (2.0 * x1) + 1.0).sqrt().recip()),
        "Misra1d" => b[0] * b[1] * x1 / (b[1] * x1 + 1.0),
        "Chwirut1" | "Chwirut2" => exp(b[0] * -x1) / (b[1] + b[2] * x1),
        "DanWood" => b[0] * exp(b[1] * x1.ln()),
        "Eckerle4" => b[0] / b[1] * exp(((-b[2] + x1) / b[1]).square() * -0.5),
        "Gauss1" | "Gauss2" | "Gauss3" => {
            b[0] * exp(b[1] * -x1) + b[2] * exp(-((-b[3] + x1) / b[4]).square()) + b[5] * exp(-((-b[6] + x1) / b[7]).square())
        }
        "Hahn1" | "Thurber" => {
            (b[0] + b[1] * x1 + b[2] * (x1 * x1) + b[3] * (x1 * x1 * x1)) / (b[4] * x1 + b[5] * (x1 * x1) + b[6] * (x1 * x1 * x1) + 1.0)
        }
        "Kirby2" => (b[0] + b[1] * x1 + b[2] * (x1 * x1)) / (b[3] * x1 + b[4] * (x1 * x1) + 1.0),
        "Lanczos1" | "Lanczos2" | "Lanczos3" => b[0] * exp(b[1] * -x1) + b[2] * exp(b[3] * -x1) + b[4] * exp(b[5] * -x1),
        "MGH09" => b[0] * (b[1] * x1 + x1 * x1) / (b[2] * x1 + b[3] + x1 * x1),
        "MGH10" => b[0] * exp(b[1] / (b[2] + x1)),
        "MGH17" => b[0] + b[1] * exp(b[3] * -x1) + b[2] * exp(b[4] * -x1),
        "Rat42" => b[0] / (exp(b[1] - b[2] * x1) + 1.0),
        "Rat43" => b[0] / power(exp(b[1] - b[2] * x1) + 1.0, b[3].recip()),
        "Bennett5" => b[0] * power(b[1] + x1, -b[2].recip()),
        "Nelson" => b[0] - b[1] * x1 * exp(b[2] * -x[1]),
        "Roszman1" => b[0] - b[1] * x1 - arctan(b[2] / (-b[3] + x1)) * std::f64::consts::FRAC_1_PI,
        "ENSO" => {
            let (sin, cos) = (std::f64::consts::TAU * x1 / 12.0).sin_cos();
            let (sin4, cos4) = (b[3].recip() * (std::f64::consts::TAU * x1)).sin_cos();
            let (sin7, cos7) = (b[6].recip() * (std::f64::consts::TAU * x1)).sin_cos();
            b[0] + b[1] * cos + b[2] * sin + b[4] * cos4 + b[5] * sin4 + b[7] * cos7 + b[8] * sin7
        }
        _ => panic!("no model of {name}"),
    }
}

/// A problem: data, and what should come out.
struct Case {
    name: String,
    starts: Vec<Vec<f64>>,
    parameters: Vec<f64>,
    deviations: Vec<f64>,
    sum_of_squares: f64,
    y: Vec<f64>,
    x: Vec<Vec<f64>>,
}

struct Found {
    parameters: Vec<f64>,
    deviations: Vec<f64>,
    sum_of_squares: f64,
    evaluations: usize,
    derivatives: usize,
    ended: String,
    converged: bool,
}

fn solve(case: &Case, start: &[f64], analytic: bool) -> Found {
    let calls = Cell::new(0);
    let residuals = |b: &[f64], r: &mut [f64]| {
        calls.set(calls.get() + 1);
        let b: Vec<Dual<0>> = b.iter().map(|&b| Dual::constant(b)).collect();
        for (i, x) in case.x.iter().enumerate() {
            r[i] = model(&case.name, &b, x).value - case.y[i];
        }
    };
    let options = FitOptions { observed: case.y.clone(), ..FitOptions::default() };
    let fitted = if analytic {
        let jacobian = |b: &[f64], j: &mut nalgebra::DMatrix<f64>| {
            let unit = |k: usize| std::array::from_fn(|i| f64::from(u8::from(i == k)));
            let b: Vec<Dual<MOST>> = b.iter().enumerate().map(|(k, &value)| Dual { value, slope: unit(k) }).collect();
            for (i, x) in case.x.iter().enumerate() {
                let slope = model(&case.name, &b, x).slope;
                j.row_mut(i).iter_mut().zip(slope).for_each(|(entry, slope)| *entry = slope);
            }
        };
        fit_with_jacobian(residuals, jacobian, case.y.len(), start, &options)
    } else {
        fit(residuals, case.y.len(), start, &options)
    }
    .unwrap();
    // What is reported is what was spent, but for the last look at the residuals.
    assert!((1..=2).contains(&(calls.get() - fitted.evaluations - fitted.derivative_evaluations)), "{}: {}", case.name, calls.get());
    Found {
        parameters: fitted.values(),
        deviations: fitted.parameters.iter().map(|p| p.standard_error.unwrap_or(f64::NAN)).collect(),
        sum_of_squares: fitted.sum_of_squares,
        evaluations: fitted.evaluations,
        derivatives: fitted.derivative_evaluations,
        ended: format!("{}, {} restarts", fitted.termination, fitted.restarts),
        converged: fitted.termination.converged(),
    }
}

/// Log relative error: digits that agree, 11 at most, which is what NIST certifies.
fn digits(found: f64, certified: f64) -> f64 {
    let error = ((found - certified) / certified).abs();
    if error.is_nan() { 0.0 } else { (-error.log10()).clamp(0.0, 11.0) }
}

fn least(found: &[f64], certified: &[f64]) -> f64 {
    found.iter().zip(certified).map(|(f, c)| digits(*f, *c)).fold(11.0, f64::min)
}

fn certified() -> Vec<Case> {
    let strd: Value = serde_json::from_str(include_str!("fixtures/strd_nonlinear.json")).unwrap();
    let number = |value: &Value| value.as_str().unwrap().parse::<f64>().unwrap();
    let numbers = |value: &Value| value.as_array().unwrap().iter().map(number).collect::<Vec<f64>>();
    let case = |set: &Value| Case {
        name: set["name"].as_str().unwrap().to_string(),
        starts: set["starts"].as_array().unwrap().iter().map(numbers).collect(),
        parameters: numbers(&set["parameters"]),
        deviations: numbers(&set["standard_deviations"]),
        sum_of_squares: number(&set["sum_of_squares"]),
        y: numbers(&set["y"]),
        x: set["x"].as_array().unwrap().iter().map(numbers).collect(),
    };
    strd["nonlinear"].as_array().unwrap().iter().map(case).collect()
}

/// Solves each case from each start; the least digits of parameters and of standard deviations, and what was spent.
fn scores(cases: &[Case], analytic: bool) -> Vec<(String, f64, f64, usize, usize)> {
    let mut scores = Vec::new();
    for case in cases {
        for (i, start) in case.starts.iter().enumerate() {
            let found = solve(case, start, analytic);
            let (parameters, deviations) = (least(&found.parameters, &case.parameters), least(&found.deviations, &case.deviations));
            println!(
                "{:9} {}  parameters {parameters:5.1}  deviations {deviations:5.1}  sum of squares {:5.1}  {:4} + {:4} evaluations  {}",
                case.name,
                i + 1,
                digits(found.sum_of_squares, case.sum_of_squares),
                found.evaluations,
                found.derivatives,
                found.ended
            );
            assert!(found.converged, "{} {}: {}", case.name, i + 1, found.ended);
            scores.push((format!("{} {}", case.name, i + 1), parameters, deviations, found.evaluations, found.derivatives));
        }
    }
    scores
}

/// Evaluations from both starts: with exact derivatives, with numeric ones, and for these.
const SPENT: [(&str, [usize; 3]); 26] = [
    ("BoxBOD 1", [44, 47, 686]),
    ("BoxBOD 2", [17, 17, 122]),
    ("Chwirut2 1", [16, 16, 176]),
    ("Chwirut2 2", [9, 9, 156]),
    ("DanWood 1", [8, 8, 86]),
    ("DanWood 2", [7, 7, 82]),
    ("Eckerle4 1", [106, 114, 512]),
    ("Eckerle4 2", [11, 13, 248]),
    ("Gauss1 1", [8, 8, 370]),
    ("Gauss1 2", [8, 8, 370]),
    ("Hahn1 1", [20, 28, 754]),
    ("Hahn1 2", [17, 24, 590]),
    ("Lanczos3 1", [105, 113, 1642]),
    ("Lanczos3 2", [95, 100, 1484]),
    ("MGH09 1", [131, 130, 890]),
    ("MGH09 2", [41, 37, 388]),
    ("MGH10 1", [736, 742, 4210]),
    ("MGH10 2", [145, 151, 1092]),
    ("Misra1a 1", [17, 18, 136]),
    ("Misra1a 2", [8, 9, 88]),
    ("Misra1b 1", [21, 22, 144]),
    ("Misra1b 2", [7, 15, 152]),
    ("Rat42 1", [13, 13, 170]),
    ("Rat42 2", [10, 10, 152]),
    ("Thurber 1", [56, 59, 1304]),
    ("Thurber 2", [47, 49, 1094]),
];

#[test]
fn every_certified_problem_is_solved_from_both_starts_to_nine_digits() {
    for (name, parameters, deviations, spent, _) in scores(&certified(), true) {
        assert!(9.0 <= parameters && 9.0 <= deviations, "{name}: {parameters} {deviations}");
        check_spent(&name, 0, spent);
    }
}

#[test]
fn numeric_derivatives_reach_eight_digits_and_seven_on_lanczos3() {
    for (name, parameters, deviations, spent, derivatives) in scores(&certified(), false) {
        // Lanczos3 has a condition of 1e4 and residuals of 1e-5 of the data: an error of 1e-13 in the derivatives shows in the eighth digit.
        let asked = if name.starts_with("Lanczos3") { 7.0 } else { 8.0 };
        assert!(asked <= parameters && asked <= deviations, "{name}: {parameters} {deviations}");
        check_spent(&name, 1, spent);
        check_spent(&name, 2, derivatives);
    }
}

#[test]
fn problems_of_the_forms_not_kept_here_end_in_the_same_minimum_from_both_starts_and_both_kinds_of_derivatives() {
    for analytic in [true, false] {
        for (name, parameters, deviations, ..) in scores(&generated(), analytic) {
            assert!(8.0 <= parameters, "{name}: {parameters}");
            // Lanczos1: residuals of 9e-14 are differences of numbers up to 2.5, whose rounding is 4e-16: in doubles no more of their size can
            // be known than three digits.
            let asked = if name.starts_with("Lanczos1") { 3.0 } else { 8.0 };
            assert!(asked <= deviations, "{name}: {deviations}");
        }
    }
}

/// At most what is pinned, and not much less, or the pin is to be tightened; the ends at rounding may differ by an evaluation or two with
/// another mathematical library.
fn check_spent(name: &str, which: usize, spent: usize) {
    let pinned = SPENT.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("{name} is not pinned")).1[which];
    assert!(spent <= pinned + pinned / 20 + 3 && pinned <= spent + spent / 10 + 3, "{name}: {spent} evaluations, {pinned} pinned");
}

/// A form of NIST's with data generated here: name, parameters, noise, both of NIST's starts, x.
type Form<'a> = (&'a str, &'a [f64], f64, [&'a [f64]; 2], Vec<Vec<f64>>);

/// Steps from `low` to `high`.
fn steps(low: f64, high: f64, n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| vec![low + (high - low) * i as f64 / (n - 1) as f64]).collect()
}

/// The forms whose data NIST holds and this repository does not, with data generated from nearby parameters.
///
/// The reference is the minimum reached from the generating parameters themselves, so a start that ends elsewhere is found out.
fn generated() -> Vec<Case> {
    let lanczos: &[f64] = &[0.0951, 1.0, 0.8607, 3.0, 1.5576, 5.0];
    let lanczos_starts: [&[f64]; 2] = [&[1.2, 0.3, 5.6, 5.5, 6.5, 7.6], &[0.5, 0.7, 3.6, 4.2, 4.0, 6.3]];
    let logarithmic: Vec<Vec<f64>> = steps(7.45f64.ln(), 151.9f64.ln(), 154).iter().map(|x| vec![x[0].exp()]).collect();
    let nelson: Vec<Vec<f64>> = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 48.0, 64.0]
        .iter()
        .flat_map(|&weeks| [180.0, 225.0, 250.0, 275.0].iter().flat_map(move |&c| std::iter::repeat_n(vec![weeks, c], 4)))
        .collect();
    let forms: Vec<Form> = vec![
        ("Bennett5", &[-2523.5, 46.74, 0.9322], 1.9e-3, [&[-2000.0, 50.0, 0.8], &[-1500.0, 45.0, 0.85]], logarithmic),
        ("Chwirut1", &[0.19, 0.0061, 0.0105], 3.4, [&[0.1, 0.01, 0.02], &[0.15, 0.008, 0.01]], steps(0.5, 6.0, 214)),
        (
            "ENSO",
            &[10.51, 3.08, 0.533, 44.3, -1.62, 0.525, 26.9, 0.212, 1.5],
            2.2,
            [&[11.0, 3.0, 0.5, 40.0, -0.7, -1.3, 25.0, -0.3, 1.4], &[10.0, 3.0, 0.5, 44.0, -1.5, 0.5, 26.0, -0.1, 1.5]],
            steps(1.0, 168.0, 168),
        ),
        (
            "Gauss2",
            &[99.0, 0.011, 101.9, 107.0, 23.6, 72.0, 153.3, 19.5],
            2.2,
            [&[96.0, 0.009, 103.0, 106.0, 18.0, 72.0, 151.0, 18.0], &[98.0, 0.0105, 103.0, 105.0, 20.0, 73.0, 150.0, 20.0]],
            steps(1.0, 250.0, 250),
        ),
        (
            "Gauss3",
            &[98.9, 0.0109, 100.7, 111.6, 23.3, 73.7, 147.8, 19.7],
            2.2,
            [&[94.9, 0.009, 90.1, 113.0, 20.0, 73.8, 140.0, 20.0], &[96.0, 0.0096, 80.0, 110.0, 25.0, 74.0, 139.0, 25.0]],
            steps(1.0, 250.0, 250),
        ),
        (
            "Kirby2",
            &[1.6745, -0.1393, 0.002596, -0.001724, 2.1665e-5],
            0.16,
            [&[2.0, -0.1, 0.003, -0.001, 1e-5], &[1.5, -0.15, 0.0025, -0.0015, 2e-5]],
            steps(9.65, 371.0, 151),
        ),
        ("Lanczos1", lanczos, 9e-14, lanczos_starts, steps(0.0, 1.15, 24)),
        ("Lanczos2", lanczos, 1.1e-6, lanczos_starts, steps(0.0, 1.15, 24)),
        (
            "MGH17",
            &[0.3754, 1.936, -1.465, 0.01287, 0.02212],
            1.4e-3,
            [&[50.0, 150.0, -100.0, 1.0, 2.0], &[0.5, 1.5, -1.0, 0.01, 0.02]],
            steps(0.0, 320.0, 33),
        ),
        ("Misra1c", &[636.4, 2.081e-4], 0.05, [&[500.0, 1e-4], &[600.0, 2e-4]], steps(77.6, 760.0, 14)),
        ("Misra1d", &[437.4, 3.023e-4], 0.05, [&[500.0, 1e-4], &[450.0, 3e-4]], steps(77.6, 760.0, 14)),
        ("Nelson", &[2.59, 5.618e-9, -0.0577], 0.17, [&[2.0, 1e-4, -0.01], &[2.5, 5e-9, -0.05]], nelson),
        ("Rat43", &[699.6, 5.277, 0.7596, 1.279], 28.0, [&[100.0, 10.0, 1.0, 1.0], &[700.0, 5.0, 0.75, 1.3]], steps(1.0, 15.0, 15)),
        (
            "Roszman1",
            &[0.202, -6.195e-6, 1204.5, -181.3],
            4.8e-3,
            [&[0.1, -1e-5, 1000.0, -100.0], &[0.2, -5e-6, 1200.0, -150.0]],
            steps(-4868.7, -565.0, 25),
        ),
    ];
    forms.into_iter().map(|(name, truth, noise, starts, x)| generate(name, truth, noise, starts, x)).collect()
}

fn generate(name: &str, truth: &[f64], noise: f64, starts: [&[f64]; 2], x: Vec<Vec<f64>>) -> Case {
    let b: Vec<Dual<0>> = truth.iter().map(|&b| Dual::constant(b)).collect();
    // Errors of standard deviation one without a generator: the golden section spreads them evenly over ±√3, in no order.
    let error = |i: usize| 12f64.sqrt() * ((0.618_033_988_749_894_9 * (i + 1) as f64).fract() - 0.5);
    let y = x.iter().enumerate().map(|(i, x)| model(name, &b, x).value + noise * error(i)).collect();
    let mut case = Case {
        name: name.into(),
        starts: starts.iter().map(|start| start.to_vec()).collect(),
        parameters: vec![],
        deviations: vec![],
        sum_of_squares: 0.0,
        y,
        x,
    };
    let reference = solve(&case, truth, true);
    (case.parameters, case.deviations, case.sum_of_squares) = (reference.parameters, reference.deviations, reference.sum_of_squares);
    case
}
