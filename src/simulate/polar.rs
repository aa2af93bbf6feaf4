//! The paper's equation (4): the hem in polar form, by its turning points.
//!
//! `G(r) − λ r²/√(r² + r'²) = C`. Between the turning points r_1 < r_2, `λ = (G_2 − G_1)/(r_2 − r_1)`, `C = G_1 − λ r_1`, and with `A = G − C` half a fold
//! spans `∫ A dr/(r √(λ²r² − A²)) = π/m` and is `∫ λ r dr/√(λ²r² − A²) = πR/m` long. Both integrands are singular at both ends; but
//! `λ r − A = (r − r_1)(r_2 − r) D` with D the second divided difference of G, so that `r = mid − half cos θ` leaves `dr/√… = dθ/√(D (λ r + A))`, smooth and
//! periodic: the midpoint rule converges spectrally. Source: docs/model.md, section 4.

use std::f64::consts::{PI, TAU};

use serde::Serialize;

use super::{Branch, Effort, Folds, Multiplier, Prediction, TermEnergy, Termination, ruled};
use crate::error::Error;
use crate::experiment::{Point, Skirt};
use crate::numerics::jet::Jet;

/// A solution of equation (4).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Turning {
    /// r_1, m.
    pub inner: f64,
    /// r_2, m.
    pub outer: f64,
    /// λ, N/m².
    pub lambda: f64,
    /// C, N/m.
    pub constant: f64,
}

/// What equation (4) can say about one fold count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Hem radius at which m folds start, m: the root of `m² G′(r) = r G″(r)`.
    pub onset: f64,
    /// Hem radius at which the polar form ends, m: A reaches 0 and the curve turns radial. `None` if the slant ends first.
    pub limit: Option<f64>,
}

/// A prediction from equation (4) at a given fold count; round below the onset, overhanging (outside the paper) past the limit.
pub(super) fn predict(skirt: &Skirt, weight: f64, foundation: f64, folds: Folds, effort: &Effort) -> Result<Prediction, Error> {
    let Folds::Exactly(m) = folds else {
        return Err(Error::Unanswerable(
            "equation (4) has no bending energy: ever finer folds cost ever less, so it cannot choose the fold count; give one (--folds M)"
                .into(),
        ));
    };
    if !(foundation.is_finite() && 0.0 <= foundation) {
        return Err(Error::Invalid { quantity: "foundation modulus, N/m³", value: foundation, allowed: ">= 0" });
    }
    let equation = Equation { nodes: effort.nodes, ..Equation::new(skirt, weight, foundation, m) };
    let hem = skirt.hem_radius().0;
    let mut notes = vec![
        "equation (4) has no bending and lets every ring but the hem be any length: the fold count is as given, not predicted".to_string(),
    ];
    let beyond = || Error::Unanswerable(format!("{m} folds of this hem length reach further than the slant: equation (4) has no solution"));
    let Some(onset) = equation.onset().filter(|onset| *onset < hem) else {
        notes.push(format!("the hem is shorter than the onset of {m} folds: only the circle solves equation (4)"));
        return Ok(round(skirt, &equation, m, notes));
    };
    let (state, evaluations) = equation.continuation(onset, |state| hem <= state.radius()).ok_or_else(beyond)?;
    let (state, more) =
        equation.refine(state, hem).ok_or_else(|| Error::Unanswerable("equation (4): the turning points were not found".into()))?;
    let evaluations = evaluations + more;
    let turning = equation.turning(&state);
    if 0.0 < turning.constant {
        notes.push("past the limit of the polar form: the curve overhangs, a continuation that is outside the paper".into());
    }
    let (energy, outline) = (state.functional * 2.0 * f64::from(m), equation.outline(&state, ruled::outline_points(m)));
    let branch = Branch {
        asked: m,
        folds: m,
        harmonics: None,
        energy,
        depth: turning.outer - turning.inner,
        threshold_rigidity: None,
        lowest_curvature: None,
        termination: Termination::Converged,
    };
    Ok(Prediction {
        fidelity: "polar".into(),
        folds: m,
        energy,
        energy_unit: "N/m",
        terms: vec![TermEnergy { term: "functional", energy, evaluations }],
        hem_radius_min: turning.inner,
        hem_radius_max: turning.outer,
        coefficients: Vec::new(),
        outline,
        termination: Termination::Converged,
        evaluations,
        branches: vec![branch],
        notes,
        hem: None,
        hem_rms: None,
        multiplier: Some(Multiplier { value: turning.lambda, unit: "N/m²" }),
        turning: Some(turning),
        error_estimate: None,
        contacts: Vec::new(),
        screening: None,
        graded: None,
    })
}

fn round(skirt: &Skirt, equation: &Equation, asked: u32, notes: Vec<String>) -> Prediction {
    let radius = skirt.hem_radius().0;
    let energy = TAU * equation.density(radius);
    let branch = Branch {
        asked,
        folds: 0,
        harmonics: None,
        energy,
        depth: 0.0,
        threshold_rigidity: None,
        lowest_curvature: None,
        termination: Termination::Round,
    };
    Prediction {
        fidelity: "polar".into(),
        folds: 0,
        energy,
        energy_unit: "N/m",
        terms: vec![TermEnergy { term: "functional", energy, evaluations: 1 }],
        hem_radius_min: radius,
        hem_radius_max: radius,
        coefficients: Vec::new(),
        outline: ruled::circle(radius),
        termination: Termination::Round,
        evaluations: 1,
        branches: vec![branch],
        notes,
        hem: None,
        hem_rms: None,
        multiplier: None,
        turning: None,
        error_estimate: None,
        contacts: Vec::new(),
        screening: None,
        graded: None,
    }
}

/// Where m-fold solutions of equation (4) start and where the polar form ends. The hem radius of `skirt` plays no part.
///
/// `weight` is ρ_A g, N/m²; `foundation` is E, N/m³. `None` if no circle within reach of the slant buckles into m folds.
pub fn range(skirt: &Skirt, weight: f64, foundation: f64, folds: u32) -> Option<Range> {
    let equation = Equation::new(skirt, weight, foundation, folds);
    let onset = equation.onset()?;
    let limit = equation
        .continuation(onset, |state| 0.0 <= state.constant.value)
        .and_then(|(state, _)| equation.refine_limit(state))
        .map(|state| state.radius());
    Some(Range { onset, limit })
}

/// A number with its derivatives by (mid, half).
type PairJet = Jet<2>;

#[derive(Debug, Clone, Copy)]
struct Equation {
    waist: f64,
    slant: f64,
    weight: f64,
    foundation: f64,
    folds: f64,
    /// Nodes of the integrals; `None`: doubled until they hold.
    nodes: Option<usize>,
}

/// The integrals of equation (4) at one pair of turning points.
#[derive(Debug, Clone, Copy)]
struct State {
    mid: f64,
    half: f64,
    /// Half a fold's angle, rad.
    angle: PairJet,
    /// Half a fold's length, times m/π, m: the hem radius that it belongs to.
    length: PairJet,
    lambda: PairJet,
    constant: PairJet,
    /// ∫ G dφ over half a fold, N/m.
    functional: f64,
}

impl State {
    fn radius(&self) -> f64 {
        self.length.value
    }
}

/// Everything at one radius between the turning points.
struct Local<const N: usize> {
    radius: Jet<N>,
    /// A = G − C.
    lift: Jet<N>,
    /// √(D (λ r + A)).
    root: Jet<N>,
}

impl Equation {
    fn new(skirt: &Skirt, weight: f64, foundation: f64, folds: u32) -> Self {
        Equation { waist: skirt.waist_radius().0, slant: skirt.slant_length().0, weight, foundation, folds: f64::from(folds), nodes: None }
    }

    /// G, N/m.
    fn density(&self, radius: f64) -> f64 {
        let x = radius - self.waist;
        let height = (self.slant * self.slant - x * x).sqrt();
        self.weight * x * x / (self.slant + height) + 0.5 * self.foundation * x * x
    }

    /// Root of m² G′(r) = r G″(r), by bisection between the waist and the reach of the slant.
    fn onset(&self) -> Option<f64> {
        let excess = |r: f64| {
            let x = r - self.waist;
            let height = (self.slant * self.slant - x * x).sqrt();
            let first = self.weight * x / height + self.foundation * x;
            let second = self.weight * self.slant * self.slant / height.powi(3) + self.foundation;
            self.folds * self.folds * first - r * second
        };
        // Quadratic G gives R_t m²/(m² − 1); a stiffening G moves it out. Scan for the first sign change.
        const CELLS: usize = 4000;
        let at = |i: usize| self.waist + self.slant * i as f64 / CELLS as f64;
        let cell = (1..CELLS).find(|i| 0.0 <= excess(at(*i)))?;
        let (mut low, mut high) = (at(cell - 1), at(cell));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if excess(middle) < 0.0 { low = middle } else { high = middle }
        }
        Some(0.5 * (low + high))
    }

    /// Half-height √(L² − x²) with its derivatives.
    fn height<const N: usize>(&self, x: Jet<N>) -> Jet<N> {
        (x.square() * -1.0 + self.slant * self.slant).sqrt()
    }

    /// λ and C. The divided difference of the square root is formed without cancellation: h[1,2] = −(x_1 + x_2)/(h_1 + h_2).
    fn multipliers<const N: usize>(&self, mid: Jet<N>, half: Jet<N>) -> (Jet<N>, Jet<N>) {
        let (x1, x2) = (mid - half - self.waist, mid + half - self.waist);
        let (h1, h2) = (self.height(x1), self.height(x2));
        let lambda = (x1 + x2) * ((h1 + h2).recip() * self.weight + 0.5 * self.foundation);
        let inner = x1.square() * ((h1 + self.slant).recip() * self.weight + 0.5 * self.foundation);
        (lambda, inner - lambda * (mid - half))
    }

    fn local<const N: usize>(&self, mid: Jet<N>, half: Jet<N>, lambda: Jet<N>, constant: Jet<N>, cos: f64) -> Local<N> {
        let radius = mid - half * cos;
        let (x1, x2, x) = (mid - half - self.waist, mid + half - self.waist, radius - self.waist);
        let (h1, h2, h) = (self.height(x1), self.height(x2), self.height(x));
        let density = x.square() * ((h + self.slant).recip() * self.weight + 0.5 * self.foundation);
        let lift = density - constant;
        // −h[1, 2, x], again free of cancellation.
        let bend = ((h1 + h2) * (h1 + h) + (x1 + x2) * (x1 + x)) / ((h1 + h2) * (h2 + h) * (h1 + h));
        let root = ((bend * self.weight + 0.5 * self.foundation) * (lambda * radius + lift)).sqrt();
        Local { radius, lift, root }
    }

    fn within(&self, mid: f64, half: f64) -> bool {
        0.0 < mid - half && mid + half - self.waist < self.slant && self.waist - mid + half < self.slant && 0.0 <= half
    }

    /// The integrals at turning points mid ∓ half; nodes are doubled until they hold (`hemline study accuracy`: 32 would do for ordinary skirts, in a
    /// third of the time, but near the onset and at the slant's end nobody knows beforehand). `None` outside the reach of the slant.
    fn state(&self, mid: f64, half: f64) -> Option<State> {
        if !self.within(mid, half) {
            return None;
        }
        let (m, h) = (Jet::variable(mid, 0), Jet::variable(half, 1));
        let (lambda, constant) = self.multipliers(m, h);
        let mut nodes = self.nodes.map_or(16, |nodes| nodes.max(2));
        let mut last: Option<State> = None;
        loop {
            let (mut angle, mut length, mut functional) = (Jet::constant(0.0), Jet::constant(0.0), 0.0);
            for i in 0..nodes {
                let cos = (PI * (i as f64 + 0.5) / nodes as f64).cos();
                let local = self.local(m, h, lambda, constant, cos);
                let swept = local.lift / (local.radius * local.root);
                angle = angle + swept * (PI / nodes as f64);
                length = length + lambda * local.radius / local.root * (self.folds / nodes as f64);
                functional += (local.lift.value + constant.value) * swept.value * (PI / nodes as f64);
            }
            let state = State { mid, half, angle, length, lambda, constant, functional };
            if !(angle.value.is_finite() && length.value.is_finite()) {
                return None;
            }
            let still = last.is_some_and(|l| {
                (l.angle.value - angle.value).abs() <= 1e-14 * angle.value.abs()
                    && (l.length.value - length.value).abs() <= 1e-14 * length.value
            });
            if still || self.nodes.is_some() || 4096 <= nodes {
                return Some(state);
            }
            (last, nodes) = (Some(state), 2 * nodes);
        }
    }

    /// The middle radius at which turning points `half` away from it span half a fold.
    fn middle(&self, mut mid: f64, half: f64, evaluations: &mut usize) -> Option<State> {
        for _ in 0..50 {
            let state = self.state(mid, half)?;
            *evaluations += 1;
            let step = (PI / self.folds - state.angle.value) / state.angle.gradient[0];
            if !step.is_finite() {
                return None;
            }
            if step.abs() <= 1e-13 * mid {
                return Some(state);
            }
            // The angle grows like √λ from λ = 0 at the waist: no step may cross it.
            let floor = self.waist + 0.2 * (mid - self.waist);
            mid = (mid + step).clamp(floor, mid + 0.2 * self.waist);
        }
        None
    }

    /// From the circle outward until `done`: the first state past it, and the evaluations spent. `None` if the slant or the axis ends it first.
    fn continuation(&self, onset: f64, done: impl Fn(&State) -> bool) -> Option<(State, usize)> {
        let mut evaluations = 0;
        let (mut mid, mut half, mut step) = (onset, 1e-3 * onset, 0.02 * onset);
        let mut state = self.middle(mid, half, &mut evaluations)?;
        for _ in 0..2000 {
            if done(&state) {
                return Some((state, evaluations));
            }
            match self.middle(mid, half + step, &mut evaluations) {
                Some(next) => {
                    (mid, half, state) = (next.mid, next.half, next);
                }
                None => step *= 0.5,
            }
            if step < 1e-6 * onset {
                return None;
            }
        }
        None
    }

    /// Newton on (angle, length) = (π/m, hem radius) from a state near it.
    fn refine(&self, start: State, hem: f64) -> Option<(State, usize)> {
        self.newton(start, |s| [(s.angle, PI / self.folds), (s.length, hem)])
    }

    /// Newton on (angle, C) = (π/m, 0).
    fn refine_limit(&self, start: State) -> Option<State> {
        self.newton(start, |s| [(s.angle, PI / self.folds), (s.constant, 0.0)]).map(|(state, _)| state)
    }

    fn newton(&self, start: State, equations: impl Fn(&State) -> [(PairJet, f64); 2]) -> Option<(State, usize)> {
        let mut state = start;
        for evaluations in 1..=60 {
            let [(f, a), (g, b)] = equations(&state);
            let (df, dg) = (a - f.value, b - g.value);
            let determinant = f.gradient[0] * g.gradient[1] - f.gradient[1] * g.gradient[0];
            let (mut mid, mut half) =
                ((df * g.gradient[1] - f.gradient[1] * dg) / determinant, (f.gradient[0] * dg - df * g.gradient[0]) / determinant);
            if mid.hypot(half) <= 1e-14 * state.mid {
                return Some((state, evaluations));
            }
            // Near the onset the length is stationary in half, and Newton overshoots: halve until it stays a fold within reach.
            let next = (0..30).find_map(|_| {
                let trial = (0.0 < state.half + half).then(|| self.state(state.mid + mid, state.half + half)).flatten();
                (mid, half) = (0.5 * mid, 0.5 * half);
                trial
            })?;
            let stuck = (next.mid - state.mid).hypot(next.half - state.half) <= 4.0 * f64::EPSILON * state.mid;
            state = next;
            if stuck {
                return Some((state, evaluations));
            }
        }
        // Rounding keeps the last steps at a few parts in 10¹⁴ where the two equations are nearly dependent.
        let [(f, a), (g, b)] = equations(&state);
        ((f.value - a).abs() <= 1e-12 * a.abs().max(f.value.abs()) && (g.value - b).abs() <= 1e-12 * state.mid).then_some((state, 60))
    }

    fn turning(&self, state: &State) -> Turning {
        Turning { inner: state.mid - state.half, outer: state.mid + state.half, lambda: state.lambda.value, constant: state.constant.value }
    }

    /// `n` points equally spaced in length, the first on a crest on the x axis, m.
    fn outline(&self, state: &State, n: usize) -> Vec<Point> {
        let modes = self.nodes.map_or(256, |nodes| nodes.max(2));
        let (mid, half) = (Jet::<0>::constant(state.mid), Jet::constant(state.half));
        let (lambda, constant) = (Jet::constant(state.lambda.value), Jet::constant(state.constant.value));
        // dφ/dθ and ds/dθ are even and periodic: cosine series, integrated term by term. θ = π is the crest.
        let nodes: Vec<(f64, f64)> = (0..modes)
            .map(|i| {
                let local = self.local(mid, half, lambda, constant, (PI * (i as f64 + 0.5) / modes as f64).cos());
                (local.lift.value / (local.radius.value * local.root.value), lambda.value * local.radius.value / local.root.value)
            })
            .collect();
        let series: Vec<(f64, f64)> = (0..modes)
            .map(|k| {
                let share = if k == 0 { 1.0 } else { 2.0 } / modes as f64;
                let cosine = |i: usize| (PI * k as f64 * (i as f64 + 0.5) / modes as f64).cos();
                nodes.iter().enumerate().fold((0.0, 0.0), |sum, (i, (a, b))| (sum.0 + share * a * cosine(i), sum.1 + share * b * cosine(i)))
            })
            .collect();
        // Angle and length from the crest at θ = π.
        let swept = |theta: f64| {
            let (mut angle, mut length, mut slope) = (series[0].0 * (theta - PI), series[0].1 * (theta - PI), series[0].1);
            for (k, (a, b)) in series.iter().enumerate().skip(1) {
                let (sin, cos) = (k as f64 * theta).sin_cos();
                angle += a * sin / k as f64;
                length += b * sin / k as f64;
                slope += b * cos;
            }
            (angle, length, slope)
        };
        let fold = TAU * state.radius() / self.folds;
        (0..n)
            .map(|i| {
                let whole = TAU * state.radius() * i as f64 / n as f64;
                let turns = (whole / fold).floor();
                let target = whole - turns * fold;
                let mut theta = PI + TAU * target / fold;
                for _ in 0..40 {
                    let (_, length, slope) = swept(theta);
                    let step = (target - length) / slope;
                    theta += step;
                    if step.abs() < 1e-13 {
                        break;
                    }
                }
                let (sin, cos) = (swept(theta).0 + turns * TAU / self.folds).sin_cos();
                let radius = state.mid - state.half * theta.cos();
                Point::new(radius * cos, radius * sin)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Metre;

    fn skirt(hem: f64) -> Skirt {
        Skirt::new(Metre(0.121), Metre(hem), Metre(0.53)).unwrap()
    }

    #[test]
    fn integrals_derivatives_agree_with_central_differences() {
        let equation = Equation::new(&skirt(0.1452), 1.962, 20.0, 5);
        let (exact, h) = (equation.state(0.127, 0.02).unwrap(), 1e-6);
        for i in 0..2 {
            let at = |sign: f64| {
                equation.state(0.127 + if i == 0 { sign * h } else { 0.0 }, 0.02 + if i == 1 { sign * h } else { 0.0 }).unwrap()
            };
            let (up, down) = (at(1.0), at(-1.0));
            for (e, u, d) in
                [(exact.angle, up.angle, down.angle), (exact.length, up.length, down.length), (exact.constant, up.constant, down.constant)]
            {
                // Truncation h²f‴/6 ~ 1e-7 f′ with lengths of millimetres above the waist.
                assert!((e.gradient[i] - (u.value - d.value) / (2.0 * h)).abs() < 1e-6 * (1.0 + e.gradient[i].abs()));
            }
        }
    }

    #[test]
    fn outline_closes_is_even_and_turns_at_its_turning_points() {
        for hem in [0.1452, 0.2362, 0.31] {
            let prediction = predict(&skirt(hem), 1.962, 0.0, Folds::Exactly(5), &Effort::default()).unwrap();
            let outline = &prediction.outline;
            let turning = prediction.turning.unwrap();
            let radii: Vec<f64> = outline.iter().map(|p| p.x.hypot(p.y)).collect();
            assert!((radii[0] - turning.outer).abs() < 1e-12);
            assert!((radii[outline.len() / 10] - turning.inner).abs() < 1e-9);
            for i in 0..outline.len() {
                let chord = outline[i].distance(outline[(i + 1) % outline.len()]) * outline.len() as f64 / TAU;
                // A chord is short by (arc·κ)²/24, with 720 points and κ up to 10/R some 3e-4.
                assert!((chord / hem - 1.0).abs() < 1e-3, "{hem}: {i} {chord}");
            }
        }
    }
}
