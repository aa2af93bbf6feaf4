//! The cone and its flat pattern, fields on draped surfaces, and their export: against closed forms, and read back by independent readers.

use std::f64::consts::{PI, TAU};

use hemline::experiment::campaign::Meshes;
use hemline::experiment::{Fabric, Skirt};
use hemline::import::mesh;
use hemline::model::field::{Field, Sheet, SurfaceFields};
use hemline::model::pattern::{Options as PatternOptions, Pattern};
use hemline::model::skirt::{Cone, from_body};
use hemline::report::pattern::{Paper, dxf, pdf, svg};
use hemline::report::surface::{Colour, Legend, Options as WriteOptions, glb, write};
use hemline::simulate::{Fidelity, Folds, Options as PredictOptions, Prediction, predict};
use hemline::study::surface::{Options as SurfaceOptions, of_prediction, sheet};
use hemline::units::{KilogramPerSquareMetre, Metre, NewtonMetre, STANDARD_GRAVITY};

fn table_one() -> Skirt {
    from_body(Metre(0.76), Metre(1.04), Metre(0.20), Metre(0.53)).unwrap()
}

/// A quarter panel with allowances of 15, 10 and 30 mm.
fn quarter() -> Pattern {
    let options =
        PatternOptions { panels: 4, seam_allowance: 0.015, waist_allowance: 0.010, hem_allowance: 0.030, ..PatternOptions::default() };
    Pattern::of(&Cone::of(&table_one()), &options).unwrap()
}

/// Layer, and the vertices: x, y, bulge.
type Polyline = (String, Vec<(f64, f64, f64)>);

/// The closed polylines of a drawing, by layer: vertices (x, y, bulge), mm. Reads group codes and values as the format defines them, knows nothing of us.
fn polylines(text: &str) -> Vec<Polyline> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    assert_eq!(lines.len() % 2, 0, "codes and values come in pairs");
    let mut out: Vec<Polyline> = Vec::new();
    let mut entity = "";
    let mut vertex: Option<(f64, f64, f64)> = None;
    for pair in lines.chunks(2) {
        let (code, value) = (pair[0].parse::<i32>().expect("a group code"), pair[1]);
        let number = || value.parse::<f64>().expect("a number");
        match (code, entity) {
            (0, _) => {
                if let (Some(v), Some(last)) = (vertex.take(), out.last_mut()) {
                    last.1.push(v);
                }
                entity = value;
                if entity == "POLYLINE" {
                    out.push((String::new(), vec![]));
                }
                if entity == "VERTEX" {
                    vertex = Some((0.0, 0.0, 0.0));
                }
            }
            (8, "POLYLINE") => out.last_mut().expect("a polyline").0 = value.to_string(),
            (70, "POLYLINE") => assert_eq!(value, "1", "a closed polyline"),
            (10, "VERTEX") => vertex.as_mut().expect("a vertex").0 = number(),
            (20, "VERTEX") => vertex.as_mut().expect("a vertex").1 = number(),
            (42, "VERTEX") => vertex.as_mut().expect("a vertex").2 = number(),
            _ => (),
        }
    }
    out
}

/// Length and area of a closed polyline with bulges: a bulge is tan(angle/4) of an arc over the chord, to its left if positive.
fn length_and_area(vertices: &[(f64, f64, f64)]) -> (f64, f64) {
    let (mut length, mut area) = (0.0, 0.0);
    for (i, &(x, y, bulge)) in vertices.iter().enumerate() {
        let (u, v, _) = vertices[(i + 1) % vertices.len()];
        let (chord, angle) = ((u - x).hypot(v - y), 4.0 * bulge.atan());
        area += 0.5 * (x * v - u * y);
        if bulge == 0.0 {
            length += chord;
        } else {
            let radius = 0.5 * chord / (0.5 * angle).sin();
            length += radius * angle;
            // The segment between chord and arc, with the sign of the turn.
            area += 0.5 * radius * radius * (angle - angle.sin());
        }
    }
    (length, area)
}

#[test]
fn the_dxf_read_back_has_the_cloth_s_lengths_and_area_in_millimetres() {
    let words = ["skirt β = 1.35".to_string()];
    for (pattern, pieces) in [(Pattern::of(&Cone::of(&table_one()), &PatternOptions::default()).unwrap(), 1.0), (quarter(), 4.0)] {
        let text = dxf(&pattern, &words);
        assert!(text.is_ascii() && text.contains("\\U+03B2") && text.ends_with("EOF\n"));
        let read = polylines(&text);
        assert_eq!(read.iter().map(|(layer, _)| layer.as_str()).collect::<Vec<_>>(), ["CUT", "SEAM"]);
        let (length, area) = length_and_area(&read[1].1);
        let cone = Cone::of(&table_one());
        let girths = TAU * (cone.waist_radius + cone.hem_radius) / pieces;
        // Coordinates have nine places after the point, in mm.
        assert!((length - 1e3 * (girths + 2.0 * cone.slant_length)).abs() < 1e-6, "{length}");
        let cloth = PI * (cone.waist_radius + cone.hem_radius) * cone.slant_length / pieces;
        assert!((area.abs() - 1e6 * cloth).abs() < 1e-3, "{area}");
        let (_, cut) = length_and_area(&read[0].1);
        assert!((cut.abs() - 1e6 * pattern.cut_area()).abs() < 1e-3);
    }
}

#[test]
fn the_svg_is_as_large_as_the_pattern_and_its_margin_in_millimetres() {
    let pattern = quarter();
    let text = svg(&pattern, &["<cut> & sew".into()]);
    let (low, high) = pattern.bounds();
    let attribute = |name: &str| {
        let at = text.find(&format!(" {name}=\"")).expect("the attribute") + name.len() + 3;
        text[at..].split('"').next().expect("a value").to_string()
    };
    let size = |name: &str| attribute(name).strip_suffix("mm").expect("millimetres").parse::<f64>().unwrap();
    // Coordinates are rounded to a thousandth of a millimetre.
    assert!(
        (size("width") - (1e3 * (high.x - low.x) + 20.0)).abs() < 1e-3 && (size("height") - (1e3 * (high.y - low.y) + 20.0)).abs() < 1e-3
    );
    let view: Vec<f64> = attribute("viewBox").split(' ').map(|v| v.parse().unwrap()).collect();
    assert_eq!(view, [0.0, 0.0, size("width"), size("height")]);
    // The arc of the waist's seam has the radius of the pattern, R_v = R_t/cos β.
    let radius = 1e3 * Cone::of(&table_one()).pattern_radius.unwrap();
    assert!(text.contains(&format!("A{radius:.2}")), "{radius}");
    assert!(text.contains("&lt;cut&gt; &amp; sew") && !text.contains("NaN"));
}

/// Width and height of every page box of a PDF, mm.
fn page_boxes(bytes: &[u8]) -> Vec<(f64, f64)> {
    let text: String = bytes.iter().map(|&b| char::from(b)).collect();
    let boxes = text.match_indices("/MediaBox").map(|(at, _)| {
        let inside = text[at..].split_once('[').and_then(|(_, rest)| rest.split_once(']')).expect("a box").0;
        let sides: Vec<f64> = inside.split_whitespace().map(|v| v.parse().unwrap()).collect();
        ((sides[2] - sides[0]) * 25.4 / 72.0, (sides[3] - sides[1]) * 25.4 / 72.0)
    });
    boxes.collect()
}

#[test]
fn the_pdf_has_pages_of_true_size_whole_or_in_tiles() {
    let pattern = quarter();
    let (low, high) = pattern.bounds();
    let whole = page_boxes(&pdf(&pattern, &[], Paper::Whole).unwrap());
    assert_eq!(whole.len(), 1);
    // A point is 0.35 mm and the typesetter keeps it to a hundredth.
    assert!((whole[0].0 - (1e3 * (high.x - low.x) + 20.0)).abs() < 0.01 && (whole[0].1 - (1e3 * (high.y - low.y) + 20.0)).abs() < 0.01);
    let tiles = page_boxes(&pdf(&pattern, &[], Paper::A4).unwrap());
    // 429 × 606 mm on windows of 190 × 277 mm that overlap by 10: 3 columns by 3 rows.
    assert_eq!(tiles.len(), 9);
    assert!(tiles.iter().all(|(w, h)| (w - 210.0).abs() < 0.01 && (h - 297.0).abs() < 0.01));
}

/// The reference scene of docs/model.md, section 5, with cloth 0.5 mm thick and ν = 0.2.
fn reference() -> (Skirt, Fabric, Sheet) {
    let skirt = Skirt::new(Metre(0.121), Metre(0.2362), Metre(0.53)).unwrap();
    let fabric = Fabric { areal_density: Some(KilogramPerSquareMetre(0.2)), flexural_rigidity: Some(NewtonMetre(1e-5)) };
    (skirt, fabric, sheet(&fabric, STANDARD_GRAVITY, Some(Metre(5e-4)), Some(0.2)))
}

fn predicted(fidelity: Fidelity, folds: Folds, rigidity: f64) -> (Skirt, Prediction) {
    let (skirt, fabric, _) = reference();
    let fabric = Fabric { flexural_rigidity: Some(NewtonMetre(rigidity)), ..fabric };
    (skirt, predict(&skirt, &fabric, &PredictOptions { fidelity, folds, ..PredictOptions::default() }).unwrap())
}

const RULED: Fidelity = Fidelity::Ruled { harmonics: 12 };
const GRADED: Fidelity = Fidelity::Graded { harmonics: 3, modes: 6, shear: 0.0 };

#[test]
fn on_the_round_cone_every_field_is_its_closed_form() {
    // Cloth too stiff to fold: κ = sin β/R along the rings, 0 along the generatrices; N = ρ_A g · area below/(2πR sin β).
    for fidelity in [RULED, GRADED] {
        let (skirt, prediction) = predicted(fidelity, Folds::Auto, 1.0);
        assert_eq!(prediction.folds, 0);
        let (_, _, sheet) = reference();
        let surface = of_prediction(&skirt, &prediction, &sheet, &SurfaceOptions { rows: 9, columns: 24 }).unwrap();
        let cone = Cone::of(&skirt);
        let (sine, thickness, rigidity, poisson) = (cone.base_angle.sin(), 5e-4, 1e-5, 0.2);
        let modulus = 12.0 * rigidity * (1.0 - poisson * poisson) / 1.25e-10;
        for i in 0..surface.rows * surface.columns {
            let slant = surface.slant_distance[i / surface.columns];
            let ring = cone.ring_radius(slant);
            let kappa = sine / ring;
            let below = PI * (ring + cone.hem_radius) * (cone.slant_length - slant);
            let force = 1.962 * below / (TAU * ring * sine);
            let moment = 6.0 * rigidity / (thickness * thickness) * kappa;
            let intensity = |face: f64| {
                let (around, down) = (face * moment, force / thickness + face * poisson * moment);
                (around * around - around * down + down * down).sqrt()
            };
            let is = |field: Field, exact: f64, scale: f64| {
                let value = surface.values(field).unwrap()[i];
                // Rounding of a dozen operations on numbers of the field's own scale.
                assert!((value - exact).abs() < 1e-12 * scale, "{}: {value} {exact}", field.name());
            };
            is(Field::Flexure, 0.0, 1.0);
            is(Field::RingCurvature, 1.0 / ring, 10.0);
            is(Field::NormalCurvatureRing, kappa, 10.0);
            is(Field::NormalCurvatureGeneratrix, 0.0, 100.0);
            is(Field::PrincipalCurvatureGreatest, kappa, 100.0);
            is(Field::PrincipalCurvatureLeast, 0.0, 100.0);
            is(Field::MeanCurvature, 0.5 * kappa, 100.0);
            is(Field::GaussianCurvature, 0.0, 1000.0);
            is(Field::RingStrain, 0.0, 10.0);
            is(Field::MembraneForce, force, 10.0);
            is(Field::MembraneStress, force / thickness, 1e4);
            is(Field::BendingStressOuter, modulus * thickness * kappa / 2.0, 1e5);
            is(Field::BendingStressInner, -modulus * thickness * kappa / 2.0, 1e5);
            is(Field::StressIntensityOuter, intensity(1.0), 1e5);
            is(Field::StressIntensityInner, intensity(-1.0), 1e5);
            is(Field::StressIntensity, intensity(1.0).max(intensity(-1.0)), 1e5);
        }
        // Outwards and down: the normal of the cone.
        assert!(surface.normals.iter().zip(&surface.positions).all(|(n, p)| {
            let outwards = (n[0] * p[0] + n[1] * p[1]) / p[0].hypot(p[1]);
            (outwards - sine).abs() < 1e-12 && (n[2] - cone.base_angle.cos()).abs() < 1e-12
        }));
    }
}

/// ∮∫ f dA over the cloth, trapezoid along both (ends of the slant by half; round the ring it is spectral).
fn over_cloth(surface: &SurfaceFields, skirt: &Skirt, f: impl Fn(usize) -> f64) -> f64 {
    let cone = Cone::of(skirt);
    let mut sum = 0.0;
    for row in 0..surface.rows {
        let at = |row: usize| surface.slant_distance[row];
        let width = 0.5 * (at((row + 1).min(surface.rows - 1)) - at(row.saturating_sub(1)));
        let mean = (0..surface.columns).map(|j| f(row * surface.columns + j)).sum::<f64>() / surface.columns as f64;
        sum += TAU * cone.ring_radius(at(row)) * width * mean;
    }
    sum
}

#[test]
fn bending_energy_of_the_fields_is_that_of_the_theory_and_converges_at_second_order() {
    // Ruled: (B/2) ∫ κ², κ the curvature of the ring from above; U_b of docs/model.md, section 5, K = 12. Graded: (B/2) ∫ (κ1² + κ2²).
    let (_, _, sheet) = reference();
    for fidelity in [RULED, GRADED] {
        let (skirt, prediction) = predicted(fidelity, Folds::Exactly(5), 1e-5);
        let exact = prediction.energy_of("bending").unwrap();
        if fidelity == RULED {
            // The bending energy of a minimum is as near as its coefficients: to their convergence, 1e-8.
            assert!((exact / 0.001135373449 - 1.0).abs() < 5e-8);
        }
        let error = |rows: usize| {
            let surface = of_prediction(&skirt, &prediction, &sheet, &SurfaceOptions { rows, columns: 480 }).unwrap();
            let plan = surface.values(Field::RingCurvature).unwrap();
            let (greatest, least) =
                (surface.values(Field::PrincipalCurvatureGreatest).unwrap(), surface.values(Field::PrincipalCurvatureLeast).unwrap());
            let energy = over_cloth(&surface, &skirt, |i| match fidelity {
                Fidelity::Ruled { .. } => 0.5e-5 * plan[i] * plan[i],
                _ => 0.5e-5 * (greatest[i] * greatest[i] + least[i] * least[i]),
            });
            energy / exact - 1.0
        };
        let errors = [error(41), error(81), error(161), error(321)];
        let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
        eprintln!("{}: relative errors {errors:?}, orders {orders:?}", prediction.fidelity);
        // The trapezoid along the slant is of second order.
        assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15) && errors[3].abs() < 1e-3, "{errors:?} {orders:?}");
    }
}

#[test]
fn curvatures_agree_with_differences_of_the_mesh_at_second_order() {
    let (_, _, cloth) = reference();
    let (skirt, prediction) = predicted(RULED, Folds::Exactly(5), 1e-5);
    let fit_like = prediction.hem.unwrap();
    let ruled = |n: usize| of_prediction(&skirt, &prediction, &cloth, &SurfaceOptions { rows: 20 * n + 1, columns: 180 * n }).unwrap();
    let eighteen = |n: usize| {
        let grid = hemline::model::field::linear(&skirt, fit_like, 20 * n + 1, 180 * n);
        hemline::model::field::surface_fields("linear", 5, &skirt, &grid, &cloth)
    };
    let surfaces: [&dyn Fn(usize) -> SurfaceFields; 2] = [&ruled, &eighteen];
    for make in surfaces {
        // The same places on every grid, away from waist and hem, off the symmetry lines.
        let worst = |n: usize| {
            let surface = make(n);
            let p = |row: usize, column: usize| surface.positions[row * surface.columns + column % surface.columns];
            let (h, k) = (TAU / surface.columns as f64, 0.53 / (surface.rows - 1) as f64);
            let mut worst = [0.0_f64; 2];
            for (row, column) in [(5 * n, 7 * n), (10 * n, 10 * n), (15 * n, 3 * n), (18 * n, 15 * n)] {
                let sum = |a: [f64; 3], b: [f64; 3], f: f64| [0, 1, 2].map(|i| a[i] + f * b[i]);
                let over = |a: [f64; 3], f: f64| a.map(|x| x / f);
                let middle = p(row, column);
                let u = over(sum(p(row, column + 1), p(row, column - 1), -1.0), 2.0 * h);
                let v = over(sum(p(row + 1, column), p(row - 1, column), -1.0), 2.0 * k);
                let uu = over(sum(sum(p(row, column + 1), p(row, column - 1), 1.0), middle, -2.0), h * h);
                let vv = over(sum(sum(p(row + 1, column), p(row - 1, column), 1.0), middle, -2.0), k * k);
                let uv = over(
                    sum(
                        sum(p(row + 1, column + 1), p(row + 1, column - 1), -1.0),
                        sum(p(row - 1, column + 1), p(row - 1, column - 1), -1.0),
                        -1.0,
                    ),
                    4.0 * h * k,
                );
                let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
                let normal = surface.normals[row * surface.columns + column];
                let (e, f, g) = (dot(u, u), dot(u, v), dot(v, v));
                let (l, m, n2) = (-dot(uu, normal), -dot(uv, normal), -dot(vv, normal));
                let area = e * g - f * f;
                let (mean, gauss) = (0.5 * (e * n2 - 2.0 * f * m + g * l) / area, (l * n2 - m * m) / area);
                let at = row * surface.columns + column;
                worst[0] = worst[0].max((surface.values(Field::MeanCurvature).unwrap()[at] - mean).abs());
                worst[1] = worst[1].max((surface.values(Field::GaussianCurvature).unwrap()[at] - gauss).abs());
            }
            worst
        };
        let errors = [worst(2), worst(4), worst(8)];
        for i in 0..2 {
            let orders = [(errors[0][i] / errors[1][i]).log2(), (errors[1][i] / errors[2][i]).log2()];
            // Central differences are of second order.
            assert!((orders[1] - 2.0).abs() < 0.2, "{errors:?} {orders:?}");
        }
    }
}

#[test]
fn extremes_settle_under_refinement_and_stand_where_the_folds_are_sharpest() {
    let (_, _, sheet) = reference();
    for fidelity in [RULED, GRADED] {
        let (skirt, prediction) = predicted(fidelity, Folds::Exactly(5), 1e-5);
        let at = |n: usize| of_prediction(&skirt, &prediction, &sheet, &SurfaceOptions { rows: 40 * n + 1, columns: 90 * n }).unwrap();
        let surfaces = [at(1), at(2), at(4), at(8), at(16)];
        for field in [Field::StressIntensity, Field::RingCurvature, Field::BendingStressOuter] {
            let greatest: Vec<f64> = surfaces.iter().map(|s| s.greatest(field).unwrap().value).collect();
            let finest = greatest[4];
            let left: Vec<f64> = greatest[..4].iter().map(|g| (1.0 - g / finest).abs()).collect();
            eprintln!("{} {}: {finest:.6e} {}, left {left:?}", prediction.fidelity, field.name(), field.unit());
            // A smooth maximum between grid points is missed by the square of the step: a quarter each time, at worst from the first grid's 5 %.
            for (i, left) in left.iter().enumerate() {
                assert!(*left < 0.05 / 4f64.powi(i as i32), "{} {}: {left}", prediction.fidelity, field.name());
            }
        }
        // The valleys of the hem hang furthest inside the cone: by the prediction's own radius. Outside it hang crests at most, by millimetres.
        let (least, greatest) = (surfaces[0].least(Field::Flexure).unwrap(), surfaces[0].greatest(Field::Flexure).unwrap());
        let at_hem = (least.slant_distance - 0.53).abs() < 1e-12;
        assert!((least.value - (prediction.hem_radius_min - 0.2362)).abs() < 1e-9 && at_hem, "{least:?}");
        assert!((least.sigma - PI / 5.0).abs() < 1e-12 && -1e-9 < greatest.value && greatest.value < 5e-3, "{greatest:?}");
    }
}

#[test]
fn fields_whose_cloth_data_are_missing_say_which() {
    let (skirt, prediction) = predicted(RULED, Folds::Exactly(5), 1e-5);
    let options = SurfaceOptions { rows: 5, columns: 60 };
    let surface = of_prediction(&skirt, &prediction, &Sheet { weight: Some(1.962), ..Sheet::default() }, &options).unwrap();
    assert!(surface.values(Field::MembraneForce).is_ok() && surface.values(Field::MeanCurvature).is_ok());
    let why = surface.values(Field::StressIntensity).unwrap_err();
    assert!(why.contains("thickness") && why.contains("rigidity") && why.contains("Poisson") && !why.contains("density"), "{why}");
    assert_eq!(surface.greatest(Field::BendingStressOuter), None);
    assert!(surface.values(Field::MembraneStress).unwrap_err().contains("thickness"));
    let wrong = Sheet { thickness: Some(0.0), ..Sheet::default() };
    assert!(of_prediction(&skirt, &prediction, &wrong, &options).is_err());
    let (_, polar) = predicted(Fidelity::Polar { foundation: 0.0 }, Folds::Exactly(5), 1e-5);
    assert!(of_prediction(&skirt, &polar, &Sheet::default(), &options).unwrap_err().to_string().contains("no surface"));
}

#[test]
fn every_format_read_back_is_the_surface_that_was_written() {
    let (_, _, sheet) = reference();
    let folder = tempfile::tempdir().unwrap();
    for (fidelity, folds) in [(RULED, 5), (GRADED, 5), (Fidelity::Ansatz, 5)] {
        let (skirt, prediction) = predicted(fidelity, Folds::Exactly(folds), 1e-5);
        let surface = of_prediction(&skirt, &prediction, &sheet, &SurfaceOptions { rows: 17, columns: 360 }).unwrap();
        let low = surface.positions.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
        let outline: Vec<[f64; 3]> = surface.positions[(surface.rows - 1) * surface.columns..].to_vec();
        let length =
            |p: &[[f64; 3]]| -> f64 { p.iter().zip(p.iter().cycle().skip(1)).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum() };
        for ending in ["glb", "gltf", "obj", "ply", "stl"] {
            let path = folder.path().join(format!("skirt.{ending}"));
            write(&surface, &WriteOptions::of(Field::StressIntensity), &path).unwrap();
            let axis = match ending {
                "glb" | "gltf" => None,
                "obj" => Some([0.0, 1.0, 0.0]),
                _ => Some([0.0, 0.0, 1.0]),
            };
            let frame = Meshes { axis, unit: None };
            let mesh = mesh::read(&path, &mesh::Options { frame, zero: mesh::Zero::Highest, ..mesh::Options::default() }).unwrap();
            assert_eq!(mesh.size(), (surface.rows * surface.columns, 2 * (surface.rows - 1) * surface.columns), "{ending}");
            let unit = if ending == "stl" { 1e-3 } else { 1.0 };
            assert_eq!(mesh.metres_per_unit, unit, "{ending}");
            // Single precision of half a metre; seven places after the point in OBJ.
            assert!((mesh.range[0] - low).abs() < 2e-7 && mesh.range[1] == 0.0, "{ending}: {:?}", mesh.range);
            let (hem, _) = mesh.hem().unwrap();
            let points: Vec<[f64; 3]> = hem.points().iter().map(|p| [p.x, p.y, 0.0]).collect();
            assert!((length(&points) - length(&outline)).abs() < 1e-5, "{ending}: {} {}", length(&points), length(&outline));
        }
    }
    let (skirt, prediction) = predicted(RULED, Folds::Exactly(5), 1e-5);
    let surface = of_prediction(&skirt, &prediction, &sheet, &SurfaceOptions::default()).unwrap();
    let refused = write(&surface, &WriteOptions::of(Field::Flexure), &folder.path().join("skirt.fbx")).unwrap_err().to_string();
    assert!(refused.contains(".glb"), "{refused}");
}

#[test]
fn the_glb_holds_the_raw_field_unit_normals_and_colours_of_its_legend() {
    let (_, _, sheet) = reference();
    let (skirt, prediction) = predicted(GRADED, Folds::Exactly(5), 1e-5);
    let surface = of_prediction(&skirt, &prediction, &sheet, &SurfaceOptions { rows: 9, columns: 60 }).unwrap();
    let legend = Legend::of(&surface, Field::StressIntensity, None).unwrap();
    let bytes = glb(&surface, &legend);
    // Header and chunks by the format's own layout.
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let text = word(12);
    assert!(text % 4 == 0 && &bytes[16..20] == b"JSON" && &bytes[20 + text + 4..20 + text + 8] == b"BIN\0");
    let document: serde_json::Value = serde_json::from_slice(&bytes[20..20 + text]).unwrap();
    let binary = &bytes[28 + text..];
    let primitive = &document["meshes"][0]["primitives"][0];
    let floats = |name: &str, width: usize| -> Vec<Vec<f32>> {
        let accessor = &document["accessors"][primitive["attributes"][name].as_u64().unwrap() as usize];
        let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let (from, count) = (view["byteOffset"].as_u64().unwrap() as usize, accessor["count"].as_u64().unwrap() as usize);
        let number = |i: usize| f32::from_le_bytes(binary[from + 4 * i..from + 4 * i + 4].try_into().unwrap());
        (0..count).map(|row| (0..width).map(|k| number(row * width + k)).collect()).collect()
    };
    let values = surface.values(Field::StressIntensity).unwrap();
    let field = floats("_FIELD", 1);
    assert!(field.iter().zip(values).all(|(a, b)| a[0] == *b as f32) && field.len() == 9 * 60);
    assert!(floats("NORMAL", 3).iter().all(|n| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5));
    // y is up: the waist is at 0, the hem below.
    assert!(floats("POSITION", 3)[..60].iter().all(|p| p[1].abs() < 1e-7) && floats("POSITION", 3)[8 * 60][1] < -0.4);
    let extras = &document["meshes"][0]["extras"];
    let (low, high) = (extras["range"][0].as_f64().unwrap(), extras["range"][1].as_f64().unwrap());
    assert_eq!((extras["field"].as_str(), extras["unit"].as_str()), (Some("stress-intensity"), Some("Pa")));
    for (colour, value) in floats("COLOR_0", 3).iter().zip(values) {
        let expected = Colour::sequential((value - low) / (high - low)).linear;
        assert!(colour.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6));
    }
    // Equal folds differ by rounding, and the first of them is told.
    assert!((extras["greatest"]["value"].as_f64().unwrap() / high - 1.0).abs() < 1e-8);
}
