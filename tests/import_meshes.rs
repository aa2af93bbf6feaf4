//! Meshes: whatever program wrote them, the same drape comes out, its sections on the surface, its lines p(z), q(z), s(z) recovered.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use hemline::experiment::Point;
use hemline::experiment::campaign::{Folds, Meshes};
use hemline::fit;
use hemline::fit::surface::{Method, SurfaceFit};
use hemline::import::mesh::{self, Cut, DrapeMesh, LoopKind, Options, Zero};
use hemline::units::Metre;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

/// The surface of scripts/mesh_fixtures.py: p, q, s at height z, m.
fn lines(z: f64) -> [f64; 3] {
    [0.20 - 0.15 * z, 0.040 - 0.12 * z, 0.006 - 0.018 * z]
}

const FOLDS: f64 = 6.0;
const HEIGHT: f64 = 0.25;

/// A point of it, m.
fn on_surface(z: f64, t: f64) -> [f64; 3] {
    let [p, q, s] = lines(z);
    let (rho, tau) = (p + q * (FOLDS * t).cos(), s * (2.0 * FOLDS * t).sin());
    let (sin, cos) = (t + 0.3).sin_cos();
    [0.01 + rho * cos - tau * sin, -0.02 + rho * sin + tau * cos, z]
}

/// Distance of a plan-view point from the curve at height z, m.
fn from_curve(point: Point, z: f64) -> f64 {
    const N: usize = 3000;
    let corner = |i: usize| on_surface(z, TAU * i as f64 / N as f64);
    let side = |i: usize| {
        let ([ax, ay, _], [bx, by, _]) = (corner(i), corner(i + 1));
        let (ex, ey) = (bx - ax, by - ay);
        let share = (((point.x - ax) * ex + (point.y - ay) * ey) / (ex * ex + ey * ey)).clamp(0.0, 1.0);
        (point.x - ax - share * ex).hypot(point.y - ay - share * ey)
    };
    (0..N).map(side).fold(f64::INFINITY, f64::min)
}

/// How far the edges of a mesh of `n` columns (odd rows shifted by half a column if `staggered`) and `rows` rows leave the surface, m.
fn chord_error(n: usize, rows: usize, staggered: bool) -> f64 {
    let height = |row: usize| HEIGHT * row as f64 / (rows - 1) as f64;
    let corner = |row: usize, j: usize| {
        let shift = if staggered && row % 2 == 1 { 0.5 } else { 0.0 };
        on_surface(height(row), TAU * (j as f64 + shift) / n as f64)
    };
    let mut most = 0.0_f64;
    for row in 0..rows - 1 {
        // One fold shows all there is.
        for j in 0..n / 6 {
            let a = corner(row, j);
            for b in [corner(row + 1, j), corner(row + 1, j + 1)] {
                for k in 1..8 {
                    let u = f64::from(k) / 8.0;
                    let [x, y, z] = std::array::from_fn(|i| a[i] + u * (b[i] - a[i]));
                    most = most.max(from_curve(Point::new(x, y), z));
                }
            }
        }
    }
    most
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/meshes").join(name)
}

fn read(path: &Path, options: &Options) -> DrapeMesh {
    mesh::read(path, options).unwrap_or_else(|e| panic!("{e}"))
}

fn refusal(name: &str, text: impl AsRef<[u8]>, options: &Options) -> String {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, text).expect("writable");
    mesh::read(&path, options).map(|mesh| panic!("should be refused: {:?}", mesh.notes)).unwrap_err().to_string()
}

fn cuts(mesh: &DrapeMesh, heights: &[f64]) -> Vec<Cut> {
    heights.iter().map(|&height| mesh.cut(height)).collect()
}

fn surface(mesh: &DrapeMesh, count: usize, folds: Folds) -> SurfaceFit {
    let options = fit::Options { folds, ..fit::Options::default() };
    fit::surface::fit(&mesh.measured(&cuts(mesh, &mesh.heights(count))), &options).unwrap_or_else(|e| panic!("{e}"))
}

fn with_unit(metres: f64) -> Options {
    Options { frame: Meshes { axis: None, unit: Some(Metre(metres)) }, ..Options::default() }
}

/// Every file of the drape, its columns and rows, whether rows are staggered, and which direction is up.
const FILES: [(&str, usize, usize, bool, [f64; 3]); 10] = [
    ("skirt_mm.obj", 60, 6, true, [0.0, 0.0, 1.0]),
    ("skirt_ascii_mm.ply", 60, 6, true, [0.0, 0.0, 1.0]),
    ("skirt_little_mm.ply", 60, 6, true, [0.0, 0.0, 1.0]),
    ("skirt_mm.stl", 60, 6, true, [0.0, 0.0, 1.0]),
    ("quads_cm_y_up.obj", 60, 6, true, [0.0, 1.0, 0.0]),
    ("skirt.glb", 60, 6, true, [0.0, 1.0, 0.0]),
    ("skirt.gltf", 60, 6, true, [0.0, 1.0, 0.0]),
    ("coarse_big_cm.ply", 36, 3, false, [0.0, 0.0, 1.0]),
    ("coarse_down_m_ascii.stl", 36, 3, false, [0.0, 0.0, -1.0]),
    ("coarse_mm_numpy.stl", 36, 3, false, [0.0, 0.0, 1.0]),
];

#[test]
fn sections_of_every_format_lie_on_the_surface_within_the_chord_error_of_the_mesh() {
    for (name, n, rows, staggered, up) in FILES {
        let mesh = read(&file(name), &Options::default());
        assert_eq!(mesh.up, up, "{name}: {:?}", mesh.notes);
        assert_eq!(mesh.size(), (n * rows, 2 * n * (rows - 1)), "{name}: duplicate vertices are one, quads are two triangles");
        assert!((mesh.range[1] - HEIGHT).abs() < 1e-6 && mesh.range[0] == 0.0, "{name}: {:?}", mesh.range);
        let allowed = chord_error(n, rows, staggered);
        let mut farthest = 0.0_f64;
        for cut in cuts(&mesh, &[0.013, 0.05, 0.111, 0.2, 0.249]) {
            let outline = cut.outline.unwrap_or_else(|e| panic!("{name} at {}: {e}", cut.height));
            assert!(cut.others.is_empty() && outline.bridged == 0.0, "{name}");
            assert!(n <= outline.profile.points().len(), "{name}: {} points", outline.profile.points().len());
            for &point in outline.profile.points() {
                // Frames are turned, never mirrored, and axes of the file exchanged in turn: the plan is the same for every file.
                farthest = farthest.max(from_curve(point, cut.height));
            }
        }
        println!("{name}: farthest {:.4} mm, chord error {:.4} mm", 1e3 * farthest, 1e3 * allowed);
        // Between the eighths at which the chord error is taken, and the file's own digits.
        assert!(farthest <= 1.02 * allowed + 2e-6, "{name}: {farthest} > {allowed}");
        assert!(0.2 * allowed < farthest, "{name}: the bound says nothing");
    }
}

#[test]
fn lines_of_the_surface_come_back_from_every_format() {
    for (name, n, _, _, _) in FILES.into_iter().filter(|f| f.1 == 60) {
        let mesh = read(&file(name), &Options::default());
        let fitted = surface(&mesh, 5, Folds::default());
        assert_eq!((fitted.folds, &fitted.method), (6, &Method::Joint), "{name} {n}");
        let [[a1, a2, a3], [b1, b2, b3]] = [lines(0.0), std::array::from_fn(|i| lines(1.0)[i] - lines(0.0)[i])];
        for (line, a, b) in [(&fitted.p, a1, b1), (&fitted.q, a2, b2), (&fitted.s, a3, b3)] {
            // Vertices lie on the surface to the digits of the file, 1e-4 mm in text, 1e-7 of 250 mm in binary.
            assert!((line.a.value - a).abs() < 1e-7 && (line.b.value - b).abs() < 1e-6, "{name}: {line:?} {a} {b}");
        }
        assert!(fitted.rms < 1e-7, "{name}: {}", fitted.rms);
        assert!((fitted.phase.value - 0.3).abs() < 1e-5, "{name}: {:?}", fitted.phase);
        let lack = fitted.lack_of_fit[0].expect("five sections");
        // Sections cut the corners of the mesh; the surface fit, which takes vertices, does not.
        assert!(lack.rms < 1e-3 && lack.explained.is_some_and(|e| 0.99 < e), "{name}: {lack:?}");
    }
}

#[test]
fn the_hem_is_the_lower_rim_and_the_frame_can_be_asked_for() {
    let hem = mesh::hem(&file("skirt_ascii_mm.ply"), &Options::default()).expect("a hem");
    assert_eq!(hem.profile.points().len(), 60);
    assert!(hem.profile.points().iter().all(|&p| from_curve(p, 0.0) < 1e-6));
    assert!(hem.notes.iter().any(|n| n.contains("longest rim")), "{:?}", hem.notes);
    let highest = read(&file("skirt_mm.obj"), &Options { zero: Zero::Highest, ..Options::default() });
    assert!((highest.range[0] + HEIGHT).abs() < 1e-6);
    // Held upside down, the narrow end is below: what was asked for counts.
    let asked = Options { frame: Meshes { axis: Some([0.0, 0.0, -2.0]), unit: None }, ..Options::default() };
    let down = read(&file("skirt_mm.obj"), &asked);
    assert_eq!((down.up, down.axis_confidence), ([0.0, 0.0, -1.0], None));
    // Half as many millimetres to the unit.
    assert!((read(&file("skirt_mm.obj"), &with_unit(5e-4)).range[1] - 0.5 * HEIGHT).abs() < 1e-6);
}

/// An OBJ in mm of the surface turned and shaken: `n` columns, `rows` rows, noise (m) on every vertex.
fn shaken(n: usize, rows: usize, noise: f64, turn: impl Fn([f64; 3]) -> [f64; 3], random: &mut ChaCha8Rng) -> String {
    let mut text = String::new();
    // Twelve uniform numbers: variance one, near enough normal.
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    for row in 0..rows {
        for j in 0..n {
            let [x, y, z] = on_surface(HEIGHT * row as f64 / (rows - 1) as f64, TAU * j as f64 / n as f64);
            let [x, y, z] = turn([x + noise * normal(), y + noise * normal(), z]).map(|v| 1e3 * v);
            writeln!(text, "v {x:.5} {y:.5} {z:.5}").expect("memory");
        }
    }
    for row in 0..rows - 1 {
        for j in 0..n {
            let (a, b) = (row * n + j + 1, row * n + (j + 1) % n + 1);
            writeln!(text, "f {a} {b} {} {}", b + n, a + n).expect("memory");
        }
    }
    text
}

#[test]
fn intervals_of_the_surface_cover_the_truth_as_often_as_they_say() {
    const REPLICATES: usize = 100;
    let mut random = ChaCha8Rng::seed_from_u64(18);
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("noisy.obj");
    let options = Options { frame: Meshes { axis: Some([0.0, 0.0, 1.0]), unit: Some(Metre(1e-3)) }, ..Options::default() };
    let (mut within, mut farthest, mut inflated) = ([0_usize; 4], 0.0_f64, 0);
    for _ in 0..REPLICATES {
        fs::write(&path, shaken(48, 5, 5e-4, |v| v, &mut random)).expect("writable");
        let fitted = surface(&read(&path, &options), 4, Folds::Exactly(6));
        inflated += usize::from(1.0 < fitted.inflation);
        let truth = [(fitted.p.a, 0.20), (fitted.p.b, -0.15), (fitted.q.a, 0.040), (fitted.q.b, -0.12)];
        for (count, (estimate, truth)) in within.iter_mut().zip(truth) {
            let score = (estimate.value - truth).abs() / estimate.standard_error.expect("an error");
            *count += usize::from(score <= 1.96);
            farthest = farthest.max(score);
        }
    }
    println!("coverage of 95 % intervals of a1, b1, a2, b2 in {REPLICATES}: {within:?}, farthest {farthest:.2}, inflated {inflated}");
    // Binomial: 95 ± 3·2.2; all four lie below or above only by a wrong error.
    assert!(within.iter().all(|&count| (88..=100).contains(&count)), "{within:?}");
    // Pooled: 380 ± 3·6.2 (a and b of one line are correlated by 0.87: between 6.2 if all and 4.4 if none were independent).
    assert!((361..=396).contains(&within.iter().sum::<usize>()), "{within:?}");
    // The largest of 400 normal numbers stays below 4.5 in all but 0.3 % of the cases.
    assert!(farthest < 4.5);
}

#[test]
fn a_tilted_scan_is_put_upright_by_its_rims() {
    // Twenty degrees about x.
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let text = shaken(60, 6, 0.0, |[x, y, z]| [x, cos * y - sin * z, sin * y + cos * z], &mut ChaCha8Rng::seed_from_u64(1));
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("tilted.obj");
    fs::write(&path, text).expect("writable");
    let mesh = read(&path, &Options::default());
    let [x, y, z] = mesh.up;
    assert!(x.abs() < 1e-6 && (y + sin).abs() < 1e-6 && (z - cos).abs() < 1e-6, "{:?} {:?}", mesh.up, mesh.notes);
    assert!(mesh.axis_confidence.is_some_and(|c| 0.8 < c), "{:?}", mesh.axis_confidence);
    let fitted = surface(&mesh, 5, Folds::default());
    assert!((fitted.p.b.value + 0.15).abs() < 1e-5 && (fitted.q.b.value + 0.12).abs() < 1e-5, "{fitted:?}");
}

#[test]
fn a_hole_is_bridged_up_to_the_stated_share_and_a_body_inside_is_told() {
    let height = 0.2;
    let at = |gap: f64| {
        let mesh = read(&file("hole_and_body_mm.obj"), &Options { largest_gap: gap, ..Options::default() });
        // The hole is in the upper of two rows of faces.
        mesh.cut(height)
    };
    let cut = at(0.05);
    let outline = cut.outline.expect("bridged");
    assert!(0.01 < outline.bridged && outline.bridged < 0.05, "{}", outline.bridged);
    assert_eq!(cut.others.iter().map(|o| o.kind).collect::<Vec<_>>(), [LoopKind::Inner]);
    // The body: a polygon of 24 corners, radius 9 cm.
    assert!((cut.others[0].length - 48.0 * 0.09 * (TAU / 48.0).sin()).abs() < 1e-6);
    // With no bridges only the body is closed, and it is not the cloth… but it is all that goes round the axis.
    let refused = at(0.0);
    assert!(refused.others.iter().any(|o| o.kind == LoopKind::Open), "{refused:?}");
    let whole = read(&file("hole_and_body_mm.obj"), &Options::default());
    let (hem, note) = whole.hem().expect("a hem");
    assert_eq!(hem.points().len(), 36, "{note}");
}

#[test]
fn a_closed_skin_gives_its_lowest_section_for_a_hem_and_its_outer_side_as_the_outline() {
    // Two sheets 4 mm apart, joined above and below.
    let (n, mut text) = (60, String::new());
    for (z, out) in [(0.0, 0.002), (HEIGHT, 0.002), (HEIGHT, -0.002), (0.0, -0.002)] {
        for j in 0..n {
            let t = TAU * j as f64 / n as f64;
            let [x, y, z] = on_surface(z, t);
            writeln!(text, "v {} {} {z}", x + out * (t + 0.3).cos(), y + out * (t + 0.3).sin()).expect("memory");
        }
    }
    for row in 0..4 {
        for j in 0..n {
            let at = |row: usize, j: usize| (row % 4) * n + j % n + 1;
            writeln!(text, "f {} {} {} {}", at(row, j), at(row, j + 1), at(row + 1, j + 1), at(row + 1, j)).expect("memory");
        }
    }
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("thick.obj");
    fs::write(&path, text).expect("writable");
    let mesh = read(&path, &Options { frame: Meshes { axis: None, unit: Some(Metre(1.0)) }, ..Options::default() });
    let cut = mesh.cut(0.1);
    assert_eq!(cut.others.iter().map(|o| o.kind).collect::<Vec<_>>(), [LoopKind::Inner]);
    let outline = cut.outline.expect("closed");
    assert!(cut.others[0].length < outline.length);
    let hem = mesh::hem(&path, &with_unit(1.0)).expect("a hem");
    assert!(hem.notes.iter().any(|n| n.contains("lowest closed section")), "{:?}", hem.notes);
}

#[test]
fn what_cannot_be_told_is_asked_and_what_is_broken_is_named() {
    let text = |name: &str| fs::read_to_string(file(name)).expect("readable");
    let options = Options::default();
    // 0.048 m or 0.48 m or 4.8 m: only one is a drape; a tenth of a metre could be ten of centimetres.
    let scaled = |factor: f64| {
        text("skirt_mm.obj")
            .lines()
            .map(|line| {
                let mut words = line.split(' ');
                if words.next() != Some("v") {
                    return format!("{line}\n");
                }
                format!("v {}\n", words.map(|w| (w.parse::<f64>().expect("a number") * factor).to_string()).collect::<Vec<_>>().join(" "))
            })
            .collect::<String>()
    };
    let both = refusal("a.obj", scaled(0.23), &options);
    assert!(both.contains("if in mm") && both.contains("if in cm") && both.contains("say the unit"), "{both}");
    assert!(refusal("a.obj", scaled(20.0), &options).contains("no drape in mm, cm or m"));
    for (name, content, said) in [
        ("a.obj", "v 0 0 0\nv 1 0 0\n".to_string(), "no mesh"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n".into(), "not there"),
        ("a.obj", "v 0 0 0\nv 1 0 zero\nv 0 1 0\nf 1 2 3\n".into(), "row 2"),
        ("a.obj", "v 0 0 0\nv 1 0 inf\nv 0 1 0\nf 1 2 3\n".into(), "inf"),
        ("a.ply", text("skirt_ascii_mm.ply").replace("element vertex 360", "element vertex 1000000000000"), "promises"),
        ("a.ply", text("skirt_ascii_mm.ply").replace("property float y\n", ""), "no property “y”"),
        ("a.ply", text("skirt_ascii_mm.ply").replace("element face 600", "element face 0"), "no faces"),
        ("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n".into(), "STL"),
        ("a.gltf", text("external.gltf"), "another file"),
        ("a.gltf", text("skirt.gltf").replace("\"bufferView\": 0", "\"bufferView\": 77"), "glTF"),
        ("a.gltf", text("skirt.gltf").replace("\"POSITION\": 1", "\"POSITION\": 9"), "not there"),
        ("a.glb", "glTF".into(), "too short"),
    ] {
        let message = refusal(name, &content, &options);
        assert!(message.contains(said), "“{said}” is not in: {message}");
    }
    let mut many = fs::read(file("skirt_mm.stl")).expect("readable");
    many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refusal("a.stl", many, &options).contains("promises"));
    // A cube has no axis.
    let cube: String = (0..8).map(|i| format!("v {} {} {}\n", i & 1, (i >> 1) & 1, i >> 2)).collect::<String>()
        + "f 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\n";
    assert!(refusal("a.obj", cube, &options).contains("which way is up"));
}

#[test]
fn a_campaign_takes_the_hem_of_a_mesh_as_a_profile() {
    let folder = TempDir::new().expect("a folder");
    fs::create_dir(folder.path().join("profiles")).expect("writable");
    let files = ["skirt_mm.obj", "skirt_little_mm.ply", "skirt_mm.stl", "skirt.glb"];
    let mut design = String::from("run,replicate,stiff,profile\n");
    for (i, name) in files.iter().enumerate() {
        fs::copy(file(name), folder.path().join("profiles").join(name)).expect("readable");
        writeln!(design, "{},{},{},profiles/{name}", i + 1, 1 + i / 2, if i % 2 == 0 { -1 } else { 1 }).expect("memory");
    }
    let toml = "title = \"meshes\"\norigin = \"made for a test\"\napparatus = \"skirt\"\n[geometry]\nwaist_radius_cm = 16\nhem_radius_cm = 25\nslant_length_cm = 27\n\
                [cloth]\nareal_density_g_m2 = 150\n[[factors]]\nname = \"stiff\"\nlow = 5\nhigh = 20\n[profiles]\nmesh_axis = \"AXIS\"\nmesh_unit = \"mm\"\n";
    fs::write(folder.path().join("design.csv"), design).expect("writable");
    fs::write(folder.path().join("campaign.toml"), toml.replace("AXIS", "up")).expect("writable");
    let refused = hemline::import::load(folder.path()).expect_err("no axis").to_string();
    assert!(refused.contains("mesh_axis") && refused.contains("row 15"), "{refused}");
    fs::write(folder.path().join("campaign.toml"), toml.replace("mesh_axis = \"AXIS\"\n", "")).expect("writable");
    let imported = hemline::import::load(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    assert!(imported.quarantine.iter().all(|q| q.run.as_deref() == Some("4")), "{:?}", imported.quarantine);
    for (i, profile) in imported.profiles.iter().take(3).enumerate() {
        let profile = profile.as_ref().unwrap_or_else(|| panic!("run {}", i + 1));
        assert!(profile.points().iter().all(|&p| from_curve(p, 0.0) < 1e-6));
    }
    assert!(imported.notes.iter().any(|n| n.starts_with("run 1:") && n.contains("hem")), "{:?}", imported.notes);
}

#[test]
fn shared_meshes_of_simulated_skirts_agree_with_their_digitised_hems() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/skirt40");
    if !folder.join("meshes").is_dir() {
        println!("skirt40 is not here: its meshes were not tried");
        return;
    }
    let mut tried = 0;
    for run in ["01", "04", "11", "18", "23", "28", "34", "37"] {
        let hem = mesh::hem(&folder.join(format!("meshes/run_{run}.ply")), &Options::default()).unwrap_or_else(|e| panic!("{e}"));
        let table = hemline::import::table::profiles(&folder.join(format!("profiles/run_{run}.csv"))).unwrap_or_else(|e| panic!("{e}"));
        let area = |points: &[Point]| hemline::experiment::profile::signed_area(points);
        let ratio = area(hem.profile.points()) / area(table.profiles[0].profile.points());
        // A polygon through the hem's vertices against a spline through them: κ²h²/12 ~ 1 % for folds of 2 cm radius at 16 mm, and 0.5 mm of noise.
        assert!((0.97..1.01).contains(&ratio), "run {run}: {ratio}");
        tried += 1;
    }
    println!("skirt40: {tried} meshes tried");
}

fn hemline(args: &[&str]) -> (String, String, Option<i32>) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_hemline")).args(args).output().expect("the program runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr), output.status.code())
}

#[test]
fn the_program_fits_a_mesh_as_an_outline_and_as_a_surface() {
    let path = file("quads_cm_y_up.obj");
    let path = path.to_str().expect("a name");
    let (table, notes, code) = hemline(&["fit", path, "--folds", "6", "--axis", "y", "--unit", "cm"]);
    assert_eq!(code, Some(0), "{notes}");
    let (header, row) = table.split_once('\n').expect("two lines");
    let column = |name: &str| header.split(',').position(|c| c == name).and_then(|at| row.split(',').nth(at)).expect("a cell").to_owned();
    assert_eq!((column("run"), column("m"), column("n_points")), ("quads_cm_y_up".into(), "6".into(), "60".into()));
    assert!((column("p_mm").parse::<f64>().expect("a number") - 200.0).abs() < 1e-3);
    let (json, _, code) = hemline(&["mesh", path, "--count", "5", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!((code, json["surface"]["m"].as_u64(), json["sections"].as_array().map(Vec::len)), (Some(0), Some(6), Some(5)));
    assert!((json["surface"]["b2"]["value"].as_f64().expect("a number") + 0.12).abs() < 1e-6);
    assert!(json["surface"]["b2"]["se"].as_f64().is_some_and(|se| 0.0 < se));
    let (sections, _, _) = hemline(&["mesh", path, "--heights-mm", "20,40", "--sections"]);
    assert!(sections.starts_with("profile,x_mm,y_mm,z_mm\nz20.0,") && sections.contains("\nz40.0,"), "{sections}");
    let (text, said, code) = hemline(&["mesh", path, "--heights-mm", "20,40,-5"]);
    // Two sections are no line, and one height is outside.
    assert!(code == Some(1) && said.contains("outside of the mesh") && text.contains("No surface"), "{said}{text}");
    let (distances, _, _) = hemline(&["mesh", path, "--every-mm", "50", "--distances"]);
    assert!(distances.starts_with("x_mm,y_mm,z_mm,distance_mm\n"), "{distances}");
}
