//! A campaign to draw in tests: the shipped one, analysed, with one run set aside.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use crate::experiment::campaign::{Folds, HemLength};
use crate::experiment::{Apparatus, Campaign, CheckRules, Design, DrapeProfile, Fabric, Factor, Point, Quarantined, Run, Skirt, Source};
use crate::statistics::box_wilson::Coefficient;
use crate::study::campaign::{CampaignStudy, Measured, analyse};
use crate::units::{CENTIMETRE, GRAM_PER_SQUARE_METRE, KilogramPerSquareMetre, MICRONEWTON_METRE, Metre, NewtonMetre};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data")
}

pub fn factors() -> Vec<Factor> {
    let factor = |name: &str, label: &str, unit: &str, low: f64, high: f64| Factor {
        name: name.into(),
        label: label.into(),
        unit: Some(unit.into()),
        low,
        high,
    };
    vec![
        factor("rigidity", "flexural rigidity", "µN·m", 5.0, 20.0),
        factor("density", "areal density", "g/m²", 150.0, 250.0),
        factor("conicity", "hem radius", "cm", 20.0, 26.0),
    ]
}

/// The shipped campaign, one run of it set aside; analysed once for all tests.
pub fn study() -> CampaignStudy {
    static STUDY: LazyLock<CampaignStudy> = LazyLock::new(analysed);
    STUDY.clone()
}

fn analysed() -> CampaignStudy {
    let table = std::fs::read_to_string(data().join("design.csv")).unwrap();
    let runs: Vec<Run> = table.lines().skip(1).map(run).collect();
    let campaign = Campaign {
        title: "Forty conic skirts, 2³ × 5".into(),
        origin: "Simulated in an independent shell simulator (MuJoCo 4.0 flex shells), not measured in a laboratory.".into(),
        apparatus: Apparatus::Skirt,
        folder: data(),
        design: Design { factors: factors(), runs: runs.clone() },
        responses: ["p_mm", "q_mm", "s_mm", "m", "rms_mm", "fold_depth_mm"].map(String::from).to_vec(),
        wishes: vec![],
        alpha: 0.05,
        folds: Folds::default(),
        hem_length: HemLength::Auto,
        bias_correction: true,
        gravity: 9.81,
        foundation_modulus: 0.0,
        pictures: None,
        meshes: Default::default(),
        check: CheckRules::usual(0.05, vec!["p_mm".into()]),
        language: Default::default(),
    };
    let profiles = runs.iter().map(profile).collect();
    let notes = vec!["Sample of the tests.".into()];
    let source = |i: u32| Source {
        file: PathBuf::from(format!("data/profiles/run_{i:02}.csv")),
        bytes: 4_000,
        digest: format!("{:016x}", 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(u64::from(i))),
    };
    let measured = Measured {
        campaign,
        profiles,
        sources: (1..=40).map(source).collect(),
        quarantine: vec![Quarantined {
            sheet: None,
            run: Some("17".into()),
            file: "data/profiles/run_17.csv".into(),
            row: Some(4),
            value: "3 points".into(),
            problem: "a profile of 3 distinct points #strong[markup] *is* text".into(),
            remedy: "at least 12 points round the whole hem are needed".into(),
        }],
        notes,
    };
    analyse(measured, &|| ())
}

fn run(line: &str) -> Run {
    let cells: Vec<&str> = line.split(',').collect();
    let number = |i: usize| cells[i].parse::<f64>().unwrap();
    Run {
        id: cells[0].into(),
        replicate: Some(number(1) as u32),
        block: None,
        levels: vec![number(2), number(3), number(4)],
        skirt: Some(Skirt::new(Metre(0.121), Metre(number(7) * CENTIMETRE), Metre(0.53)).unwrap()),
        fabric: Fabric {
            areal_density: Some(KilogramPerSquareMetre(number(6) * GRAM_PER_SQUARE_METRE)),
            flexural_rigidity: Some(NewtonMetre(number(5) * MICRONEWTON_METRE)),
        },
        profile: cells[8].into(),
    }
}

/// Run 17 is set aside, so that every table and page has something missing.
fn profile(run: &Run) -> Option<DrapeProfile> {
    let text = std::fs::read_to_string(data().join(&run.profile)).unwrap();
    let points: Vec<Point> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|c| c.parse::<f64>().unwrap() * CENTIMETRE).collect::<Vec<_>>())
        .map(|c| Point::new(c[0], c[1]))
        .collect();
    (run.id != "17").then(|| DrapeProfile::new(&points).unwrap())
}

/// Coefficients of a full 2³ model with one error for all.
pub fn coefficients() -> Vec<Coefficient> {
    let terms = [
        ("1", 161.22),
        ("rigidity", 6.31),
        ("density", -1.12),
        ("conicity", 17.4),
        ("rigidity:density", 0.31),
        ("rigidity:conicity", 2.2),
        ("density:conicity", -0.44),
        ("rigidity:density:conicity", 0.9),
    ];
    let se = 0.52;
    let coefficient = |(term, estimate): (&str, f64)| Coefficient {
        term: term.into(),
        estimate,
        se: Some(se),
        t: Some(estimate / se),
        p: Some(if estimate.abs() < 2.0369 * se { 0.2 } else { 1e-5 }),
        ci_low: Some(estimate - 2.0369 * se),
        ci_high: Some(estimate + 2.0369 * se),
        p_benjamini_hochberg: None,
        p_holm: Some(if estimate.abs() < 2.0369 * se { 1.0 } else { 1e-4 }),
        significant: 2.0369 * se < estimate.abs(),
    };
    terms.map(coefficient).to_vec()
}

/// Where somebody wants to look at what the tests draw: `HEMLINE_LOOK=folder cargo test report`.
pub fn look(name: &str, bytes: &[u8]) {
    if let Some(folder) = std::env::var_os("HEMLINE_LOOK") {
        super::output::write(Path::new(&folder), name, bytes).unwrap();
    }
}
