//! Tables and text of the paper's check: what is printed beside what is computed.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::csv::Table;
use super::figure::{paper_cone, paper_curve, paper_element, paper_projection, paper_shell};
use super::{output, raster};
use crate::error::Error;
use crate::model::skirt::Cone;
use crate::study::paper::PaperCheck;

/// One of the paper's figures, redrawn.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Its number in the paper.
    pub number: u32,
    /// What it shows.
    pub shows: &'static str,
    pub svg: String,
}

impl Figure {
    /// Name of its file without the extension.
    pub fn stem(&self) -> String {
        format!("figure_{}", self.number)
    }
}

/// Figures 1 to 5, recomputed for the checked cloth. A figure whose curve does not exist for this cloth is left out.
///
/// # Errors
/// [`Error::Output`] if one cannot be drawn.
pub fn figures(check: &PaperCheck) -> Result<Vec<Figure>, Error> {
    let slant = check.skirt.slant_length().0;
    let drawn = [
        (
            1,
            "the truncated cone of Table 1 with its dimensions",
            Some(paper_cone::draw("Figure 1. The truncated cone of Table 1", &Cone::of(&check.skirt))),
        ),
        (
            2,
            "plan view of a skirt of big conicity",
            check.wide.as_ref().map(|(skirt, hem)| {
                paper_projection::draw("Figure 2. Plan view of a skirt of big conicity", "least energy at", skirt, hem)
            }),
        ),
        (
            3,
            "space form of the surface element",
            check
                .space
                .as_ref()
                .map(|form| paper_element::draw("Figure 3. Space form of the surface element at the hem", form, slant, check.hem.folds)),
        ),
        (
            4,
            "middle curve of Table 1's skirt, approximate solution",
            Some(paper_curve::draw(
                "Figure 4. Middle curve of Table 1’s skirt, approximate solution",
                "length 2πRₙ, least energy",
                &check.skirt,
                &check.hem,
            )),
        ),
        (
            5,
            "the one-layer shell by equation (18)",
            Some(paper_shell::draw("Figure 5. The one-layer shell by equation (18)", &check.surface)),
        ),
    ];
    drawn.into_iter().filter_map(|(number, shows, svg)| Some(svg?.map(|svg| Figure { number, shows, svg }))).collect()
}

/// Writes `paper.txt`, `table1.csv`, `equations.csv`, `folds.csv`, `paper.json`, then `figure_1.svg`, `figure_1.png` and so on into `folder`; the
/// paths, in that order.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written, [`Error::Output`] if a figure cannot be drawn.
pub fn write(check: &PaperCheck, folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut summary = format!("{:#}", json(check));
    summary.push('\n');
    let figures = figures(check)?;
    let mut files = vec![
        ("paper.txt".to_string(), (text(check) + &figure_list(&figures)).into_bytes()),
        ("table1.csv".into(), table_one(check).bytes()),
        ("equations.csv".into(), equations(check).bytes()),
        ("folds.csv".into(), folds(check).bytes()),
        ("paper.json".into(), summary.into_bytes()),
    ];
    for figure in &figures {
        let picture = format!("{}.png", figure.stem());
        let png = raster::png(&picture, &figure.svg)?;
        files.push((format!("{}.svg", figure.stem()), figure.svg.clone().into_bytes()));
        files.push((picture, png));
    }
    files.iter().map(|(name, bytes)| output::write(folder, name, bytes)).collect()
}

/// Which figures there are, one line each, with the names of their files.
fn figure_list(figures: &[Figure]) -> String {
    let line = |f: &Figure| format!("Figure {}: {} ({stem}.svg, {stem}.png)\n", f.number, f.shows, stem = f.stem());
    format!("\n{}", figures.iter().map(line).collect::<String>())
}

/// The whole check in plain words, lengths in cm as the paper has them.
pub fn text(check: &PaperCheck) -> String {
    let mut out = format!("{:<22}{:>10}{:>12}  \n", "Table 1", "printed", "computed");
    for row in &check.table {
        let (printed, computed, unit, digits) = natural(row.unit, row.printed, row.computed);
        let verdict = if row.agrees() { "" } else { "  differs" };
        out += &format!("{:<22}{printed:>10.digits$}{computed:>12.3} {unit}{verdict}\n", row.quantity);
    }
    let (delta, thin) = check.thinness;
    let verdict = if thin { "below 1/20: a thin shell" } else { "not below 1/20: no thin shell" };
    out += &format!("\nThin-shell test (1): δ = {delta:.5}, {verdict}.\n\n");
    for finding in &check.findings {
        out += &format!("- {finding}\n");
    }
    out
}

/// Printed and computed value in the paper's own unit, its name, and the digits that are printed.
fn natural(unit: &str, printed: f64, computed: f64) -> (f64, f64, &'static str, usize) {
    use crate::units::CENTIMETRE;
    if unit == "m" { (printed / CENTIMETRE, computed / CENTIMETRE, "cm", 2) } else { (printed, computed, "rad", 2) }
}

/// `table1.csv`: SI units.
fn table_one(check: &PaperCheck) -> Table {
    let mut table = Table::new(&["quantity", "unit", "printed", "computed", "agrees"]);
    for row in &check.table {
        table.push(vec![row.quantity.into(), row.unit.into(), row.printed.into(), row.computed.into(), row.agrees().into()]);
    }
    table
}

/// `equations.csv`: how far equations (15) to (17) hold along the approximate solution.
fn equations(check: &PaperCheck) -> Table {
    let mut table = Table::new(&["equation", "lambda_n_m2", "constant_n_m", "unexplained_share_of_spread"]);
    if let Some(e) = &check.equations {
        for (name, fit) in [("15", &e.fifteen), ("16", &e.sixteen), ("15 + 16", &e.sum)] {
            table.push(vec![name.into(), fit.lambda.into(), fit.constant.into(), fit.residual.into()]);
        }
        table.push(vec!["17, second line".into(), None::<f64>.into(), None::<f64>.into(), e.difference.into()]);
    }
    table
}

/// `folds.csv`: the functional (10) and equation (4), fold count by fold count.
fn folds(check: &PaperCheck) -> Table {
    let mut table = Table::new(&["m", "functional_n_m", "lambda_n_m2", "onset_radius_m", "limit_radius_m"]);
    for row in &check.folds {
        table.push(vec![row.folds.into(), row.functional.into(), row.lambda.into(), row.onset.into(), row.limit.into()]);
    }
    table
}

/// Everything, SI units.
pub fn json(check: &PaperCheck) -> Value {
    let fit =
        |f: &crate::model::functional::EquationFit| json!({"lambda_n_m2": f.lambda, "constant_n_m": f.constant, "unexplained": f.residual});
    json!({
        "table1": check.table,
        "thin_shell": {"delta": check.thinness.0, "holds": check.thinness.1},
        "hem": {"folds": check.hem.folds, "p_m": check.hem.p, "q_m": check.hem.q, "s_m": check.hem.s},
        "equations": check.equations.as_ref().map(|e| json!({
            "15": fit(&e.fifteen), "16": fit(&e.sixteen), "sum": fit(&e.sum), "17_second_line_variation": e.difference,
        })),
        "folds": check.folds,
        "findings": check.findings,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Fabric;
    use crate::simulate::Cloth;
    use crate::study::paper;
    use crate::units::{KilogramPerSquareMetre, NewtonMetre, STANDARD_GRAVITY};

    #[test]
    fn printed_stands_beside_computed_in_every_form() {
        let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) };
        let check = paper::check(&Cloth::of(&fabric, STANDARD_GRAVITY).unwrap(), 0.0).unwrap();
        let words = text(&check);
        assert!(
            words.contains("23.62") && words.contains("1.37 ") && words.contains("thin shell") && !words.contains("differs"),
            "{words}"
        );
        let folder = tempfile::tempdir().unwrap();
        let written = write(&check, folder.path()).unwrap();
        let read = |i: usize| std::fs::read_to_string(&written[i]).unwrap();
        assert_eq!(read(1).lines().count(), 1 + 7);
        assert_eq!(read(2).lines().count(), 1 + 4);
        assert_eq!(read(3).lines().count(), 1 + 11);
        let value: Value = serde_json::from_str(&read(4)).unwrap();
        assert_eq!(value["hem"]["folds"], 5);
    }

    #[test]
    fn five_figures_are_redrawn_and_are_the_same_twice() {
        let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) };
        let check = || paper::check(&Cloth::of(&fabric, STANDARD_GRAVITY).unwrap(), 0.0).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let once = write(&check(), &folder.path().join("a")).unwrap();
        let twice = write(&check(), &folder.path().join("b")).unwrap();
        assert_eq!(once.len(), 5 + 2 * 5);
        let list = std::fs::read_to_string(&once[0]).unwrap();
        for number in 1..=5 {
            for ending in ["svg", "png"] {
                let name = format!("figure_{number}.{ending}");
                assert!(list.contains(&name), "{name} is not listed");
                let at = once.iter().position(|path| path.ends_with(&name)).unwrap();
                let (first, second) = (std::fs::read(&once[at]).unwrap(), std::fs::read(&twice[at]).unwrap());
                let begins: &[u8] = if ending == "svg" { b"<svg" } else { b"\x89PNG" };
                assert!(first.starts_with(begins) && first == second, "{name}");
                if ending == "svg" {
                    let svg = String::from_utf8(first).unwrap();
                    assert!(svg.contains("mm\" viewBox") && !svg.contains("NaN") && !svg.contains("inf"), "{name}");
                }
            }
        }
    }

    #[test]
    fn figures_of_cloth_at_either_end_are_drawn() {
        // From softer than silk, of many folds, to cloth too stiff for the eight folds of Figure 5.
        for rigidity in [2e-7, 1e-5, 1e-4] {
            let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(rigidity)) };
            let check = paper::check(&Cloth::of(&fabric, STANDARD_GRAVITY).unwrap(), 0.0).unwrap();
            let numbers: Vec<u32> = figures(&check).unwrap().iter().map(|f| f.number).collect();
            assert!([1, 3, 4, 5].iter().all(|n| numbers.contains(n)), "{rigidity}: {numbers:?}");
            assert_eq!(check.surface.hem.folds == 8, rigidity < 1e-4);
            assert_eq!(numbers.contains(&2), check.wide.is_some());
        }
    }
}
