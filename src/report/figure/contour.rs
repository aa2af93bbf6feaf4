//! Figure: the regression model as lines of equal response over two factors, the others held.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::main_effects::{factor_name, level_name, with_unit};
use super::sheet::{self, Area, BLUE, Chart, Drawn, FULL_WIDTH, INK, LABEL, SKY, SMALL, chart, line, solid, steps};
use crate::error::Error;
use crate::experiment::Factor;
use crate::report::number;
use crate::statistics::box_wilson::Coefficient;

const COLUMNS: usize = 3;
/// A panel: its height, and the room for what stands above its chart, mm.
const PANEL: f64 = 55.0;
const HEAD: f64 = 5.0;
const TITLE: f64 = 8.0;
/// Most panels: beyond, the first pairs of factors stand for all.
const MOST: usize = 6;
/// Cells of the grid on which a line is sought, each way. The models are at most linear in each factor, so a line is smooth at this step.
const GRID: usize = 48;
/// About so many lines over the whole range.
const LINES: f64 = 8.0;

/// One model: terms (“1”, “a”, “a:b”) with coefficients in coded units.
type Model = [(String, f64)];

/// Two factors of a panel, and what the others are held at (coded).
struct Panel {
    across: usize,
    up: usize,
    held: Vec<(usize, f64)>,
}

/// Every pair of factors; with three factors the third is held at −1 and at +1, with more the others in their middle. `model` comes
/// with what it is called. `None` with fewer than two factors, or if the model says the same everywhere.
///
/// # Errors
/// [`Error::Output`] if it cannot be drawn.
pub fn draw(response: &str, unit: &str, n: usize, factors: &[Factor], (model, called): (&Model, &str)) -> Result<Option<String>, Error> {
    let panels = panels(factors.len());
    let (low, high) = range(factors, model, &panels);
    if panels.is_empty() || high - low <= 1e-9 * high.abs().max(low.abs()) {
        return Ok(None);
    }
    let step = round_step((high - low) / LINES);
    let levels: Vec<f64> = (0..).map(|i| ((low / step).ceil() + f64::from(i)) * step).take_while(|level| *level <= high).collect();
    let rows = panels.len().div_ceil(COLUMNS);
    let height = TITLE + PANEL * rows as f64;
    let svg = sheet::draw(&format!("contours of {response}"), FULL_WIDTH, height, |area| {
        let text = format!("{}: lines of equal response by {called}, n = {n}", with_unit(response, unit));
        sheet::title(area, &text, 0.5, 2.5)?;
        panels.iter().enumerate().try_for_each(|(i, panel)| paint(area, i, panel, factors, model, &levels, step))
    })?;
    Ok(Some(svg))
}

/// Model at a point of the coded cube.
fn value(factors: &[Factor], model: &Model, at: &[f64]) -> f64 {
    let product = |term: &str| -> f64 {
        if term == "1" {
            return 1.0;
        }
        // A term that is no product of factors (curvature, a block) is none of the model over the factors.
        term.split(':').map(|name| factors.iter().position(|f| f.name == name).map_or(0.0, |k| at[k])).product()
    };
    model.iter().map(|(term, b)| b * product(term)).sum()
}

fn panels(k: usize) -> Vec<Panel> {
    let pairs = (0..k).flat_map(|i| (i + 1..k).map(move |j| (i, j)));
    match k {
        0 | 1 => vec![],
        3 => {
            let of = |held: f64| pairs.clone().map(move |(across, up)| Panel { across, up, held: vec![(3 - across - up, held)] });
            of(-1.0).chain(of(1.0)).collect()
        }
        _ => {
            let others = |i: usize, j: usize| (0..k).filter(|l| ![i, j].contains(l)).map(|l| (l, 0.0)).collect();
            pairs.clone().map(|(across, up)| Panel { across, up, held: others(across, up) }).take(MOST).collect()
        }
    }
}

fn at(k: usize, panel: &Panel, x: f64, y: f64) -> Vec<f64> {
    let mut at = vec![0.0; k];
    (at[panel.across], at[panel.up]) = (x, y);
    panel.held.iter().for_each(|&(l, level)| at[l] = level);
    at
}

/// Least and greatest value over all panels: at corners, as the model is at most linear in each factor.
fn range(factors: &[Factor], model: &Model, panels: &[Panel]) -> (f64, f64) {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let values = panels.iter().flat_map(|panel| corners.map(|(x, y)| value(factors, model, &at(factors.len(), panel, x, y))));
    values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
}

/// A step of 1, 2 or 5 times a power of ten, at least `raw`.
fn round_step(raw: f64) -> f64 {
    let power = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|s| raw <= *s).unwrap_or(10.0 * power)
}

fn paint(area: &Area<'_>, i: usize, panel: &Panel, factors: &[Factor], model: &Model, levels: &[f64], step: f64) -> Drawn {
    let width = FULL_WIDTH / COLUMNS as f64;
    let (left, top) = (width * (i % COLUMNS) as f64, TITLE + PANEL * (i / COLUMNS) as f64);
    let (across, up) = (&factors[panel.across], &factors[panel.up]);
    let held: Vec<String> = panel
        .held
        .iter()
        .map(|&(l, level)| {
            let unit = factors[l].unit.as_deref().map(|u| format!(" {u}")).unwrap_or_default();
            format!("{} {}{unit}", factors[l].name, number::plain(factors[l].natural(level)))
        })
        .collect();
    let (x_names, y_names) = (|v: f64| natural(across, v), |v: f64| natural(up, v));
    let (x_label, y_label) = (factor_name(across), factor_name(up));
    let frame = sheet::Frame {
        x: (-1.0, 1.0),
        y: (-1.0, 1.0),
        x_label: &x_label,
        y_label: &y_label,
        x_ticks: 3,
        y_ticks: 3,
        x_names: Some(&x_names),
        y_names: Some(&y_names),
        ..sheet::Frame::default()
    };
    if !held.is_empty() {
        let held = held.join(", ");
        sheet::text_left(area, &held, left + frame.left, top + 2.2, sheet::fitted(&held, width - frame.left - 1.0, LABEL), INK)?;
    }
    let plot = sheet::part(area, left, top + HEAD, width - 4.0, PANEL - HEAD - 1.0);
    let mut axes = chart(&plot, &frame)?;
    let k = factors.len();
    let values: Vec<Vec<f64>> =
        (0..=GRID).map(|r| (0..=GRID).map(|c| value(factors, model, &at(k, panel, node(c), node(r)))).collect()).collect();
    let mut taken: Vec<(f64, f64)> = vec![];
    // How large a chart's side is on paper, mm: labels keep their distance in it.
    let side = (width - 4.0 - frame.left, PANEL - HEAD - 1.0 - frame.below);
    let (low, high) = range(factors, model, std::slice::from_ref(panel));
    if levels.iter().all(|level| *level < low || high < *level) {
        // Between two lines: what the response is all over the panel.
        let (low, high) = (said(low, 0.1 * step), said(high, 0.1 * step));
        let text = if low == high { low } else { format!("{low} to {high}") };
        sheet::note(&mut axes, &text, (0.0, 0.06), 0.0, sheet::mark(SMALL, INK, HPos::Center))?;
    }
    for (number, &level) in levels.iter().enumerate() {
        let share = number as f64 / (levels.len().max(2) - 1) as f64;
        let (color, thick) = (between(SKY, BLUE, share), 0.2 + 0.25 * share);
        let lines = lines(&values, level);
        for points in &lines {
            solid(&mut axes, points, line(color, thick))?;
        }
        if let Some(longest) = lines.iter().max_by(|a, b| length(a).total_cmp(&length(b))) {
            label(&mut axes, longest, &said(level, step), side, &mut taken)?;
        }
    }
    Ok(())
}

/// A level as its ticks say it: both ends and the middle.
fn natural(factor: &Factor, coded: f64) -> String {
    if coded.abs() < 1e-6 { number::plain(factor.natural(0.0)) } else { level_name(factor, coded) }
}

fn node(i: usize) -> f64 {
    2.0 * i as f64 / GRID as f64 - 1.0
}

/// A level with the digits that its step has.
fn said(level: f64, step: f64) -> String {
    let places = (-step.log10().floor()).clamp(0.0, 9.0);
    if 9.0 <= places || 1e6 <= level.abs() { number::significant(level, 3) } else { number::fixed(level, places as usize) }
}

fn between(from: RGBColor, to: RGBColor, share: f64) -> RGBColor {
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
}

fn length(points: &[(f64, f64)]) -> f64 {
    points.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum()
}

/// The line's value on a white ground, where it is not on another label; a line too short for one stays without.
fn label(axes: &mut Chart<'_, '_>, points: &[(f64, f64)], text: &str, side: (f64, f64), taken: &mut Vec<(f64, f64)>) -> Drawn {
    let half = 0.66 * text.chars().count() as f64 + 0.4;
    let on_paper = |p: (f64, f64)| (0.5 * (p.0 + 1.0) * side.0, 0.5 * (p.1 + 1.0) * side.1);
    let free = |&p: &(f64, f64)| {
        let (x, y) = on_paper(p);
        let inside = half < x && x < side.0 - half && 1.6 < y && y < side.1 - 1.6;
        inside && taken.iter().all(|&(tx, ty)| 2.0 * half + 0.6 < (x - tx).abs() || 3.4 < (y - ty).abs())
    };
    let shares = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8];
    let place = shares.into_iter().map(|share| points[(share * (points.len() - 1) as f64).round() as usize]).find(free);
    if let Some(p) = place {
        taken.push(on_paper(p));
        let ground = [(steps(-half), steps(-1.3)), (steps(half), steps(1.3))];
        axes.draw_series(std::iter::once(EmptyElement::at(p) + Rectangle::new(ground, sheet::fill(WHITE))))?;
        sheet::note(axes, text, p, 0.0, sheet::mark(SMALL, INK, HPos::Center))?;
    }
    Ok(())
}

/// The lines on which the bilinear interpolant of a grid of values is `level`, in coded units: the marching squares, their pieces joined.
fn lines(values: &[Vec<f64>], level: f64) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<[(f64, f64); 2]> = vec![];
    for r in 0..GRID {
        for c in 0..GRID {
            let corner = |dc: usize, dr: usize| (node(c + dc), node(r + dr), values[r + dr][c + dc] - level);
            let round = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            let crossings: Vec<(f64, f64)> = (0..4)
                .filter_map(|e| {
                    let ((ax, ay, a), (bx, by, b)) = (round[e], round[(e + 1) % 4]);
                    // A value that is met exactly counts as above, on either side alike.
                    ((a < 0.0) != (b < 0.0)).then(|| (ax + (bx - ax) * a / (a - b), ay + (by - ay) * a / (a - b)))
                })
                .collect();
            match crossings[..] {
                [from, to] => pieces.push([from, to]),
                // A saddle: the value in the middle says which corners belong together.
                [p, q, s, t] => {
                    let middle = round.iter().map(|corner| corner.2).sum::<f64>();
                    let alike = (middle < 0.0) == (round[0].2 < 0.0);
                    pieces.extend(if alike { [[p, q], [s, t]] } else { [[t, p], [q, s]] });
                }
                _ => (),
            }
        }
    }
    joined(pieces)
}

/// Pieces that share an end become one line.
fn joined(mut pieces: Vec<[(f64, f64); 2]>) -> Vec<Vec<(f64, f64)>> {
    // Ends that belong together come from the same edge and differ by rounding.
    let same = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).abs() + (a.1 - b.1).abs() < 1e-9;
    let mut lines = vec![];
    while let Some([from, to]) = pieces.pop() {
        let mut line = std::collections::VecDeque::from([from, to]);
        loop {
            let (first, last) = (line[0], line[line.len() - 1]);
            let next = pieces.iter().position(|[a, b]| same(*a, last) || same(*b, last) || same(*a, first) || same(*b, first));
            let Some(i) = next else { break };
            let [a, b] = pieces.swap_remove(i);
            match () {
                () if same(a, last) => line.push_back(b),
                () if same(b, last) => line.push_back(a),
                () if same(a, first) => line.push_front(b),
                () => line.push_front(a),
            }
        }
        lines.push(line.into_iter().collect());
    }
    lines
}

/// The model that is drawn, and what it is called: that of the significant terms, or the full one where no factor is significant.
pub fn model(reduced: &Model, coefficients: &[Coefficient]) -> (Vec<(String, f64)>, &'static str) {
    if reduced.iter().any(|(term, _)| term != "1") {
        return (reduced.to_vec(), "the model of the significant terms");
    }
    (coefficients.iter().map(|c| (c.term.clone(), c.estimate)).collect(), "the full model, of which no term is significant")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_a_plane_are_straight_and_cross_the_square_once() {
        let plane: Vec<Vec<f64>> = (0..=GRID).map(|r| (0..=GRID).map(|c| 3.0 * node(c) + 2.0 * node(r)).collect()).collect();
        let found = lines(&plane, 0.37);
        assert_eq!(found.len(), 1);
        for p in &found[0] {
            assert!((3.0 * p.0 + 2.0 * p.1 - 0.37).abs() < 1e-12);
        }
        let (first, last) = (found[0][0], found[0][found[0].len() - 1]);
        // From y = −1 to y = 1: x = (0.37 ∓ 2·y)/3.
        assert!((length(&found[0]) - (first.0 - last.0).hypot(first.1 - last.1)).abs() < 1e-9);
        assert!((first.1.abs() - 1.0).abs() < 1e-12 && (last.1.abs() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_saddle_has_two_branches_and_its_line_lies_on_the_hyperbola() {
        let saddle: Vec<Vec<f64>> = (0..=GRID).map(|r| (0..=GRID).map(|c| node(c) * node(r)).collect()).collect();
        let found = lines(&saddle, 0.2);
        assert_eq!(found.len(), 2);
        for p in found.iter().flatten() {
            // On an edge the product is linear: the crossing is exact.
            assert!((p.0 * p.1 - 0.2).abs() < 1e-12);
        }
    }

    #[test]
    fn the_model_is_that_of_its_terms_at_every_corner() {
        let factor = |name: &str| Factor { name: name.into(), label: name.into(), unit: None, low: 0.0, high: 1.0 };
        let factors = [factor("a"), factor("b")];
        let model = [("1".to_string(), 10.0), ("a".into(), 2.0), ("a:b".into(), -1.0), ("curvature".into(), 99.0)];
        assert_eq!(value(&factors, &model, &[1.0, -1.0]), 13.0);
        assert_eq!(value(&factors, &model, &[-1.0, -1.0]), 7.0);
    }
}
