//! Tables as laboratories have them, and `hemline import`: every dialect gives the same hem, nothing is lost, nothing is guessed.

use std::f64::consts::PI;
use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use hemline::experiment::Point;
use hemline::import::dialect::{AngleUnit, Decimal, Dialect, Layout};
use hemline::import::table::{self, Table};
use hemline::import::tidy::{self, Content, Options};
use rust_xlsxwriter::{Formula, Workbook};
use tempfile::TempDir;

/// Radius in cm of run `k` at an angle in degrees, as scripts/lab_files.py writes it.
fn radius(run: u32, angle: u32) -> f64 {
    let t = f64::from(angle) * PI / 180.0;
    (1e3 * (20.0 + f64::from(run) + 4.0 * (5.0 * t + f64::from(run)).cos())).round() / 1e3
}

fn angles() -> impl Iterator<Item = u32> {
    (0..360).step_by(10)
}

/// The hem of run `k`, m.
fn hem(run: u32) -> Vec<Point> {
    angles().map(|a| (f64::from(a) * PI / 180.0, radius(run, a) / 100.0)).map(|(t, r)| Point::new(r * t.cos(), r * t.sin())).collect()
}

/// Coordinates of run `k` in cm, to 0.0001 cm.
fn xy(run: u32, angle: u32) -> [f64; 2] {
    let point = hem(run)[angle as usize / 10];
    [point.x, point.y].map(|v| (1e6 * v).round() / 1e4)
}

/// Farthest point of two outlines that match point by point, m.
fn farthest(a: &[Point], b: &[Point]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

fn write(folder: &TempDir, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
    fs::write(&path, bytes).expect("writable");
    path
}

fn read_as(name: &str, bytes: impl AsRef<[u8]>, told: &Dialect) -> Result<Table, hemline::Error> {
    let folder = TempDir::new().expect("a folder");
    table::read(&write(&folder, name, bytes), told)
}

fn read(bytes: impl AsRef<[u8]>) -> Table {
    read_as("run 1.csv", bytes, &Dialect::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn refusal(bytes: impl AsRef<[u8]>) -> String {
    read_as("run 1.csv", bytes, &Dialect::default()).expect_err("should be refused").to_string()
}

fn all_in(text: &str, parts: &[&str]) {
    parts.iter().for_each(|part| assert!(text.contains(part), "“{part}” is not in: {text}"));
}

/// The only profile is the hem of run 1; coordinates are written to 0.0001 cm or better, so 1 µm is rounding.
fn is_the_hem(table: &Table) {
    assert_eq!((table.profiles.len(), table.quarantine.len()), (1, 0), "{:?}", table.quarantine);
    assert!(farthest(&table.profiles[0].input, &hem(1)) < 1e-6, "{:?}", table.profiles[0].input[1]);
}

/// A polar table of run 1, one row per point.
fn polar(header: &str, row: impl Fn(u32, f64) -> String) -> String {
    angles().fold(format!("{header}\n"), |text, a| text + &row(a, radius(1, a)) + "\n")
}

mod files_of_laboratories {
    use super::*;

    #[test]
    fn every_program_hands_over_the_same_two_hems() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files");
        for (file, names, format, layout, decimal) in [
            ("libreoffice_1251_semicolon.csv", ["1", "2"], "CSV", Layout::Long, "comma"),
            ("libreoffice_utf16_tab.tsv", ["1", "2"], "CSV", Layout::Long, "comma"),
            ("libreoffice_utf8_comma_quoted.csv", ["1", "2"], "CSV", Layout::Long, "comma"),
            ("libreoffice_1252_columns.csv", ["Versuch 1", "Versuch 2"], "CSV", Layout::Columns, "comma"),
            ("libreoffice_columns.ods", ["Versuch 1", "Versuch 2"], "ODS", Layout::Columns, "none"),
            ("libreoffice_rows.xlsx", ["1", "2"], "XLSX", Layout::Rows, "none"),
            ("libreoffice_sheet_per_run.xlsx", ["Опыт 1", "Опыт 2"], "XLSX", Layout::Long, "none"),
            ("libreoffice_sheet_per_run.xls", ["Опыт 1", "Опыт 2"], "XLS", Layout::Long, "none"),
            ("libreoffice_sheet_per_run.ods", ["Опыт 1", "Опыт 2"], "ODS", Layout::Long, "none"),
            ("openpyxl_sheet_per_run.xlsx", ["Run 1", "Run 2"], "XLSX", Layout::Long, "none"),
            ("openpyxl_long_merged.xlsx", ["1", "2"], "XLSX", Layout::Long, "none"),
            ("pandas_long.csv.gz", ["1", "2"], "CSV", Layout::Long, "point"),
            ("pandas_long.parquet", ["1", "2"], "Parquet", Layout::Long, "none"),
            ("pyarrow_wide.parquet", ["1", "2"], "Parquet", Layout::Rows, "none"),
            ("pyarrow_long.feather", ["1", "2"], "Arrow", Layout::Long, "none"),
        ] {
            let table = table::profiles(&folder.join(file)).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(table.quarantine, [], "{file}");
            let found: Vec<&str> = table.profiles.iter().map(|p| p.name.as_str()).collect();
            assert_eq!(found, names, "{file}");
            for (profile, run) in table.profiles.iter().zip([1, 2]) {
                // Written to 0.0001 cm.
                assert!(farthest(&profile.input, &hem(run)) < 1e-6, "{file}, run {run}");
                assert_eq!(profile.input_rows.len(), 36);
            }
            let reading = &table.readings[0];
            assert_eq!((reading.format, reading.layout, reading.decimal), (format, layout, decimal), "{file}");
        }
    }

    #[test]
    fn what_was_found_out_is_shown() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files");
        let shown = |file: &str| {
            let table = table::profiles(&folder.join(file)).unwrap_or_else(|e| panic!("{e}"));
            (table.readings[0].clone(), table.notes.join("\n"))
        };
        let (reading, notes) = shown("libreoffice_1251_semicolon.csv");
        assert_eq!(
            (reading.encoding.as_deref(), reading.separator, reading.unit.as_str()),
            (Some("windows-1251"), Some("semicolon"), "мм")
        );
        all_in(&notes, &["“х, мм”", "windows-1251", "separator semicolon", "decimal comma"]);
        let (reading, _) = shown("libreoffice_1252_columns.csv");
        assert_eq!((reading.encoding.as_deref(), reading.header_row, reading.coordinates.as_str()), (Some("windows-1252"), 2, "degrees"));
        let (reading, _) = shown("libreoffice_utf16_tab.tsv");
        assert!(reading.encoding.is_some_and(|name| name.starts_with("UTF-16LE")));
        let (reading, notes) = shown("openpyxl_sheet_per_run.xlsx");
        assert_eq!((reading.sheet.as_deref(), reading.header_row), (Some("Run 1"), 3));
        all_in(&notes, &["sheet “Read me” holds no profiles", "Hem of run 1", "weights of the points"]);
    }
}

mod dialects {
    use super::*;

    #[test]
    fn encodings_and_compression_make_no_difference() {
        let text = polar("угол, град;радиус, см", |a, r| format!("{a};{r:.4}").replace('.', ","));
        let utf_16 = |bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
        let windows_1251: Vec<u8> = text
            .chars()
            .map(|c| match c {
                'а'..='я' => (c as u32 - 'а' as u32 + 0xE0) as u8,
                c => c as u8,
            })
            .collect();
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(text.as_bytes()).expect("memory");
        for bytes in [
            text.clone().into_bytes(),
            format!("\u{feff}{text}").into_bytes(),
            utf_16(u16::to_le_bytes),
            utf_16(u16::to_be_bytes),
            [b"\xFE\xFF".to_vec(), utf_16(u16::to_be_bytes)].concat(),
            windows_1251,
            packed.finish().expect("memory"),
            text.replace('\n', "\r\n").into_bytes(),
            text.replace('\n', "\r").into_bytes(),
        ] {
            is_the_hem(&read(bytes));
        }
    }

    #[test]
    fn polar_tables_in_every_unit_and_direction_give_the_same_hem() {
        let turn = |a: u32| f64::from(a) * PI / 180.0;
        for text in [
            polar("angle_deg,radius_cm", |a, r| format!("{a},{r}")),
            polar("angle,radius_cm", |a, r| format!("{a},{r}")),
            polar("theta [rad],r [mm]", |a, r| format!("{:.9},{:.2}", turn(a), 10.0 * r)),
            polar("phi,rho/cm", |a, r| format!("{:.9},{r}", turn(a))),
            polar("azimuth gon\tradius m", |a, r| format!("{:.6}\t{:.5}", f64::from(a) / 0.9, r / 100.0)),
            polar("angle_cw_deg,radius_cm", |a, r| format!("{},{r}", 360 - a)),
            polar("угол по часовой стрелке, град;радиус, см", |a, r| format!("-{a};{r}").replace('.', ",")),
            polar("Winkel;Radius\n°;cm", |a, r| format!("{a};{r}").replace('.', ",")),
            polar("% a scan\n# of run 1\nangle [deg]|radius [cm]", |a, r| format!("{a}|{r}")),
        ] {
            is_the_hem(&read(&text));
        }
    }

    #[test]
    fn a_turn_that_ends_where_it_began_does_not_repeat_its_first_point() {
        let text = polar("angle_deg,radius_cm", |a, r| format!("{a},{r}")) + &format!("360,{}\n", radius(1, 0));
        let table = read(text);
        assert_eq!((table.profiles[0].input.len(), table.profiles[0].profile.points().len()), (37, 36));
    }

    #[test]
    fn wide_tables_are_read_by_row_and_by_column() {
        let head: Vec<String> = angles().map(|a| a.to_string()).collect();
        let radii: Vec<String> = angles().map(|a| format!("{:.4}", radius(1, a))).collect();
        let name = |table: &Table| table.profiles[0].name.clone();
        let rows = read(format!("radius, cm\nspecimen,{}\n1,{}\n", head.join(","), radii.join(",")));
        is_the_hem(&rows);
        assert_eq!((name(&rows), rows.readings[0].layout), ("1".into(), Layout::Rows));
        let units = read(format!("run;{}\n;{}\n1;{}\n", head.join(";"), vec!["cm"; 36].join(";"), radii.join(";").replace('.', ",")));
        is_the_hem(&units);
        let named: Vec<String> = head.iter().map(|a| format!("r{a}_cm")).collect();
        is_the_hem(&read(format!("{}\n{}\n", named.join(","), radii.join(","))));
        // Fewer angles in one profile than in the other: the empty cells hold no point, and it is said.
        let columns = angles().fold(String::from("angle [deg];1 [cm];2 [cm];remark\n"), |text, a| {
            let second = if a % 20 == 0 { format!("{:.4}", radius(2, a)) } else { String::new() };
            text + &format!("{a};{:.4};{second};fine\n", radius(1, a)).replace('.', ",")
        });
        let table = read(columns);
        let points: Vec<(&str, usize)> = table.profiles.iter().map(|p| (p.name.as_str(), p.input.len())).collect();
        assert_eq!((points, table.quarantine.len()), (vec![("1", 36), ("2", 18)], 0));
        assert!(farthest(&table.profiles[0].input, &hem(1)) < 1e-6);
        all_in(&table.notes.join("\n"), &["18 empty cell(s)", "not used: “remark”"]);
    }

    #[test]
    fn weights_go_with_their_points_and_bad_ones_are_set_aside() {
        let text = angles().fold(String::from("x_cm,y_cm,weight\n"), |text, a| {
            let [x, y] = xy(1, a);
            let weight = if a == 50 { "-1".into() } else { format!("{}", 1.0 + f64::from(a) / 10.0) };
            text + &format!("{x},{y},{weight}\n")
        });
        let table = read(text);
        let profile = &table.profiles[0];
        assert_eq!((profile.weights.len(), profile.weights[0], profile.weights[5]), (35, 1.0, 7.0));
        all_in(&table.quarantine[0].to_string(), &["row 7", "“-1”", "“weight”", "not positive"]);
        let unfilled = angles().fold(String::from("x_cm,y_cm,weight\n"), |text, a| text + &format!("{},{},\n", xy(1, a)[0], xy(1, a)[1]));
        assert!(read(unfilled).profiles[0].weights.is_empty());
    }

    #[test]
    fn an_ambiguous_decimal_is_refused_with_both_readings_until_it_is_told() {
        let text =
            angles().fold(String::from("angle_deg;radius_mm\n"), |text, a| text + &format!("{a};{:.3}\n", radius(1, a)).replace('.', ","));
        // 21,234 has two readings; one radius of two digits and no other mark would decide, and there is none.
        all_in(&refusal(&text), &["“23,161”", "23.161 or 23161", "decimal = "]);
        let told = Dialect { decimal: Some(Decimal::Comma), ..Dialect::default() };
        let table = read_as("a.csv", &text, &told).unwrap_or_else(|e| panic!("{e}"));
        // The radii in cm, taken for mm.
        assert!((table.profiles[0].input[0].x - radius(1, 0) / 1000.0).abs() < 1e-12);
    }

    #[test]
    fn what_a_table_does_not_say_is_refused_until_it_is_told() {
        let sector = |header: &str| (0..20).fold(format!("{header}\n"), |text, i| text + &format!("{},2{i}.5\n", 3 * i));
        all_in(&refusal(sector("angle,radius_cm")), &["the angle has no unit", "from 0 to 57", "angle = \"deg\""]);
        let told = Dialect { angle: Some(AngleUnit::Degree), ..Dialect::default() };
        assert!(read_as("a.csv", sector("angle,radius_cm"), &told).is_ok());
        all_in(&refusal(sector("Winkel [Grad],radius_cm")), &["“grad”", "1/400 of a turn", "deg or gon"]);
        all_in(&refusal(sector("angle_deg,radius")), &["“radius” has no unit", "unit = \"cm\""]);
        let told = Dialect { unit: Some("cm".into()), ..Dialect::default() };
        assert!(read_as("a.csv", sector("angle_deg,radius"), &told).is_ok());
        let head: Vec<String> = angles().map(|a| a.to_string()).collect();
        all_in(&refusal(format!("run,{0}\n1,{0}\n", head.join(","))), &["named after angles", "no unit", "unit = \"cm\""]);
    }

    #[test]
    fn told_things_hold_against_what_would_be_found() {
        let text = format!("note;day\nx;y\n{}", polar("angle_deg;radius_cm", |a, r| format!("{a};{r:.3}")));
        let told = Dialect { header_row: Some(3), clockwise: Some(true), separator: Some(';'), ..Dialect::default() };
        let table = read_as("a.csv", &text, &told).unwrap_or_else(|e| panic!("{e}"));
        let mirrored: Vec<Point> = table.profiles[0].input.iter().map(|p| Point::new(p.x, -p.y)).collect();
        assert!(farthest(&mirrored, &hem(1)) < 1e-6);
        let told = Dialect { sheets: vec!["Run 3".into()], ..Dialect::default() };
        let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/openpyxl_sheet_per_run.xlsx");
        all_in(&table::read(&book, &told).expect_err("no such sheet").to_string(), &["no sheet “Run 3”", "“Run 1”"]);
        let told = Dialect { sheets: vec!["Run 2".into()], ..Dialect::default() };
        assert_eq!(table::read(&book, &told).expect("a sheet").profiles.len(), 1);
    }
}

mod hostile {
    use super::*;

    #[test]
    fn a_million_columns_and_a_line_without_end_are_refused() {
        let wide = (0..1_000_000).map(|i| i.to_string()).collect::<Vec<_>>().join(",");
        all_in(&refusal(format!("{wide}\n{wide}\n")), &["row 1 has 6888889 bytes", "at most 1 MiB"]);
        let short = vec![""; 1_000_000].join(",");
        all_in(&refusal(format!("{short}\n{short}\n")), &["1000000 columns", "at most 10000"]);
        let folder = TempDir::new().expect("a folder");
        let line = folder.path().join("line.csv");
        // A gigabyte without a line end, as holes: it is refused before it is read.
        fs::File::create(&line).and_then(|file| file.set_len(1 << 30)).expect("writable");
        let start = Instant::now();
        all_in(&table::profiles(&line).expect_err("refused").to_string(), &["1073741824 bytes", "at most 134217728"]);
        println!("refused in {:.2} ms", 1e3 * start.elapsed().as_secs_f64());
    }

    #[test]
    fn a_compressed_table_that_unfolds_without_end_is_refused() {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        let block = vec![b'1'; 1 << 20];
        (0..129).for_each(|_| packed.write_all(&block).expect("memory"));
        let packed = packed.finish().expect("memory");
        assert!(packed.len() < 1 << 18);
        all_in(&refusal(packed), &["unfolds to more than 128 MiB"]);
    }

    #[test]
    fn two_cells_in_opposite_corners_do_not_ask_for_the_sheet_between_them() {
        let mut book = Workbook::new();
        let sheet = book.add_worksheet();
        sheet.write_string(0, 0, "x_cm").expect("a cell");
        sheet.write_number(1_048_575, 16_383, 1.0).expect("a cell");
        let refused = read_as("a.xlsx", book.save_to_buffer().expect("memory"), &Dialect::default()).expect_err("no table").to_string();
        all_in(&refused, &["no column for y"]);
    }

    #[test]
    fn formulas_and_paths_in_cells_are_data() {
        let mut book = Workbook::new();
        let sheet = book.add_worksheet();
        for (c, name) in ["run", "x_cm", "y_cm"].into_iter().enumerate() {
            sheet.write_string(0, c as u16, name).expect("a cell");
        }
        for (r, a) in angles().enumerate() {
            let r = r as u32 + 1;
            sheet.write_string(r, 0, "../../etc/passwd").expect("a cell");
            sheet.write_number(r, 1, xy(1, a)[0]).expect("a cell");
            sheet.write_number(r, 2, xy(1, a)[1]).expect("a cell");
        }
        // A formula counts as what it last gave, and one that gave an error as no number.
        sheet.write_formula(1, 1, Formula::new("=1/0").set_result("#DIV/0!")).expect("a cell");
        let table = read_as("a.xlsx", book.save_to_buffer().expect("memory"), &Dialect::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((table.profiles[0].name.as_str(), table.profiles[0].input.len()), ("../../etc/passwd", 35));
        all_in(&table.quarantine[0].to_string(), &["sheet “Sheet1”", "row 2", "#DIV/0!", "not a number"]);
        let text = polar("angle_deg,radius_cm", |a, r| if a == 0 { "0,=2+3".into() } else { format!("{a},{r}") });
        all_in(&read(text).quarantine[0].to_string(), &["row 2", "“=2+3”", "not a number"]);
    }

    #[test]
    fn damaged_files_of_every_kind_are_a_sentence_and_never_a_panic_of_ours() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files");
        let mut state = 1_u64;
        let mut random = move |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        let into = TempDir::new().expect("a folder");
        let (mut read, mut refused) = (0, 0);
        for file in fs::read_dir(folder).expect("files").map(|f| f.expect("readable").path()).filter(|f| f.is_file()) {
            let sound = fs::read(&file).expect("readable");
            for round in 0..12 {
                let mut bytes = sound.clone();
                match round % 3 {
                    0 => bytes.truncate(random(bytes.len())),
                    1 => (0..4).for_each(|_| {
                        let at = random(bytes.len());
                        bytes[at] = random(256) as u8;
                    }),
                    _ => {
                        let (at, length) = (random(bytes.len()), random(64));
                        bytes.splice(at..(at + length).min(sound.len()), std::iter::repeat_n(0xFF, 3));
                    }
                }
                let path = write(&into, "damaged", bytes);
                match table::profiles(&path) {
                    Ok(_) => read += 1,
                    Err(error) => {
                        assert!(!error.to_string().contains('\n'), "{error}");
                        refused += 1;
                    }
                }
            }
        }
        println!("{read} damaged files still gave a profile, {refused} were refused");
        assert!(0 < read && 0 < refused);
    }
}

mod imports {
    use super::*;

    fn hemline(args: &[&str]) -> std::process::Output {
        Command::new(env!("CARGO_BIN_EXE_hemline")).args(args).output().expect("the program starts")
    }

    fn said(output: &std::process::Output) -> String {
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
    }

    /// A campaign of one factor with runs 1 to 4; the names of its profile files are empty.
    fn campaign(folder: &TempDir) -> PathBuf {
        write(
            folder,
            "trial/campaign.toml",
            "title = \"trial\"\norigin = \"made for a test\"\napparatus = \"skirt\"\n[geometry]\nwaist_radius_cm = 9\nhem_radius_cm = 22\n\
             slant_length_cm = 30\n[[factors]]\nname = \"stiff\"\nlow = 5\nhigh = 20\n\n[profiles]   # mine\nobject = \"dark\"\n",
        );
        write(folder, "trial/design.csv", "run,stiff,profile\n1,-1,\n2,1,\n3,-1,\n4,1,\n");
        folder.path().join("trial")
    }

    /// A long table of some runs, with one bad row in the first of them.
    fn long(runs: &[u32]) -> String {
        let mut text = String::from("run;x, cm;y, cm\n");
        for &run in runs {
            for a in angles() {
                let [x, y] = xy(run, a);
                text += &format!("{run};{x};{y}\n").replace('.', ",");
            }
        }
        text + &format!("{};n/a;=1\n", runs[0])
    }

    /// Every file of a folder with its bytes, but for what is hidden.
    fn state(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
        let mut files: Vec<PathBuf> = fs::read_dir(folder).expect("a folder").map(|f| f.expect("readable").path()).collect();
        files.retain(|f| f.is_file() && !f.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.')));
        files.sort();
        files.into_iter().map(|f| (f.clone(), fs::read(f).expect("readable"))).collect()
    }

    #[test]
    fn the_hem_of_a_mesh_is_a_source_too() {
        let folder = TempDir::new().expect("a folder");
        let into = campaign(&folder);
        let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/meshes/skirt.glb");
        let plan = tidy::plan(std::slice::from_ref(&mesh), &into, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(plan.profiles, ["skirt"]);
        assert!(matches!(plan.entries[0].content, Content::Mesh { points } if 12 <= points), "{:?}", plan.entries);
        assert_eq!(plan.write().expect("writable"), plan_paths());
        let again = tidy::plan(&[mesh], &into, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
        assert!(again.would_change().is_empty(), "a second time changes nothing");
    }

    #[test]
    fn an_imported_campaign_loads_with_every_point_and_every_rejected_row() {
        let folder = TempDir::new().expect("a folder");
        let into = campaign(&folder);
        let source = write(&folder, "lab/spring.csv", long(&[1, 2]));
        let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/libreoffice_sheet_per_run.ods");
        write(&folder, "lab/3.csv", polar("angle_deg,radius_cm", |a, r| format!("{a},{r}")));
        write(&folder, "lab/4.csv.gz", polar("angle_deg,radius_cm", |a, r| format!("{a},{}", r + 0.5)));
        write(&folder, "lab/protocol.doc", "no table");
        let before = state(&into);
        let options = Options::default();
        let plan = tidy::plan(&[folder.path().join("lab")], &into, &options).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(state(&into), before, "a plan changes nothing");
        assert_eq!((plan.profiles.join(" "), plan.total), ("3 4 1 2".into(), 4));
        assert!(
            plan.entries.iter().any(|e| matches!(&e.content, Content::Nothing(why) if why.contains("neither table, picture nor mesh")))
        );
        assert_eq!(plan.would_change(), ["profiles.parquet", "quarantine.csv", "campaign.toml"]);
        assert_eq!(plan.write().expect("writable"), plan_paths());
        // The user's text is kept, and points at the store.
        let toml = fs::read_to_string(into.join("campaign.toml")).expect("there");
        all_in(&toml, &["[profiles]   # mine\nfile = \"profiles.parquet\"", "object = \"dark\"\n"]);
        // Every rejected row, with what it said.
        let quarantine = fs::read_to_string(into.join("quarantine.csv")).expect("there");
        all_in(&quarantine, &["spring.csv,1,,74,n/a", "'=1", "is not a number", "correct it"]);
        assert_eq!(quarantine.lines().count(), 3);
        // The campaign runs on it.
        let imported = hemline::import::load(&into).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((imported.profiles.iter().flatten().count(), imported.quarantine.len()), (4, 0), "{:?}", imported.quarantine);
        assert!(imported.notes.iter().any(|note| note.contains("quarantine.csv lists 2")), "{:?}", imported.notes);
        let direct = table::profiles(&source).expect("a table");
        // The same bits, whichever way they came.
        assert_eq!(imported.profiles[0].as_ref(), Some(&direct.profiles[0].profile));
        // A name that is taken is set aside, unless told.
        let again = tidy::plan(std::slice::from_ref(&book), &into, &options).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((again.total, again.profiles.len()), (6, 2), "Опыт 1 is another name than 1");
        let other = write(&folder, "other/1.csv", polar("angle_deg,radius_cm", |a, r| format!("{a},{}", r + 1.0)));
        let refused = tidy::plan(std::slice::from_ref(&other), &into, &options).expect_err("taken").to_string();
        all_in(&refused, &["not one profile", "came from", "spring.csv already"]);
        let replacing = tidy::plan(&[other], &into, &Options { replace: true, ..Options::default() }).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((replacing.total, replacing.profiles.join(" ")), (4, "1".into()));
    }

    fn plan_paths() -> Vec<String> {
        ["profiles.parquet", "quarantine.csv", "campaign.toml"].map(String::from).to_vec()
    }

    #[test]
    fn importing_twice_changes_nothing_and_the_order_of_imports_neither() {
        let [one, two] = [false, true].map(|swapped| {
            let folder = TempDir::new().expect("a folder");
            let into = campaign(&folder);
            write(&folder, "trial/a.csv", long(&[1, 2]));
            write(&folder, "trial/b.csv", long(&[3, 4]));
            let mut names = ["a.csv", "b.csv"];
            if swapped {
                names.reverse();
            }
            for name in names {
                tidy::plan(&[into.join(name)], &into, &Options::default()).and_then(|plan| plan.write()).unwrap_or_else(|e| panic!("{e}"));
            }
            let once = state(&into);
            let again = tidy::plan(std::slice::from_ref(&into), &into, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!((again.would_change(), again.write().expect("writable")), (vec![], vec![]));
            assert_eq!(state(&into), once);
            once.into_iter().map(|(_, bytes)| bytes).collect::<Vec<_>>()
        });
        assert!(one == two);
    }

    #[test]
    fn a_corrected_source_takes_the_place_of_what_it_gave_before() {
        let folder = TempDir::new().expect("a folder");
        let into = campaign(&folder);
        let import = || tidy::plan(&[folder.path().join("lab.csv")], &into, &Options::default()).and_then(|p| p.write()).expect("imports");
        write(&folder, "lab.csv", long(&[1, 2, 3, 4]));
        import();
        write(&folder, "lab.csv", long(&[1, 2, 4]).replace("1;n/a;=1\n", ""));
        assert_eq!(import(), ["profiles.parquet", "quarantine.csv"]);
        assert_eq!(fs::read_to_string(into.join("quarantine.csv")).expect("there").lines().count(), 1);
        let imported = hemline::import::load(&into).unwrap_or_else(|e| panic!("{e}"));
        assert!(imported.profiles[2].is_none());
        all_in(&imported.quarantine[0].to_string(), &["run 3", "holds no profile named like the run", "import its outline"]);
    }

    #[test]
    fn the_same_bytes_under_two_names_count_once() {
        let folder = TempDir::new().expect("a folder");
        let into = campaign(&folder);
        for name in ["1.csv", "2.csv"] {
            write(&folder, &format!("lab/{name}"), polar("angle_deg,radius_cm", |a, r| format!("{a},{r}")));
        }
        let plan = tidy::plan(&[folder.path().join("lab")], &into, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((plan.total, plan.set_aside.len()), (1, 1));
        all_in(&plan.set_aside[0].to_string(), &["2.csv", "the same bytes as", "1.csv"]);
    }

    #[test]
    fn a_dry_run_shows_every_source_and_changes_nothing() {
        let folder = TempDir::new().expect("a folder");
        let into = campaign(&folder);
        let source = write(&folder, "spring.csv", long(&[1, 2, 3, 4]));
        let before = state(&into);
        let output = hemline(&["import", source.to_str().expect("text"), "--into", into.to_str().expect("text"), "--dry-run"]);
        assert_eq!((output.status.code(), state(&into)), (Some(1), before));
        let text = said(&output);
        let head = text.lines().next().expect("a header");
        all_in(head, &["source", "sheet", "encoding", "separator", "decimal", "unit", "layout", "profiles", "points", "rejected"]);
        let row: Vec<&str> = text.lines().nth(1).expect("a row").split_whitespace().collect();
        assert_eq!(&row[1..], ["–", "CSV", "UTF-8", "semicolon", "comma", "cm", "x,", "y", "long", "row", "1", "4", "144", "2"]);
        all_in(&text, &["set aside: run 1: ", "row 146, “n/a”", "would change profiles.parquet, quarantine.csv, campaign.toml"]);
    }

    #[test]
    fn campaign_toml_tells_the_dialect_of_some_files() {
        let folder = TempDir::new().expect("a folder");
        let into = campaign(&folder);
        let toml = fs::read_to_string(into.join("campaign.toml")).expect("there");
        let told = "\n[tables]\nunit = \"cm\"\n[[tables.files]]\nmatch = \"old/*.csv\"\ndecimal = \",\"\nunit = \"mm\"\n";
        write(&folder, "trial/campaign.toml", toml + told);
        write(&folder, "trial/design.csv", "run,stiff,profile\n1,-1,old/1.csv\n2,1,2.csv\n");
        write(&folder, "trial/old/1.csv", polar("angle_deg;radius", |a, r| format!("{a};{r:.4}").replace('.', ",")));
        write(&folder, "trial/2.csv", polar("angle_deg;radius", |a, r| format!("{a};{r:.3}")));
        let imported = hemline::import::load(&into).unwrap_or_else(|e| panic!("{e}"));
        let first = |run: usize| imported.profiles[run].as_ref().expect("read").points()[0].x;
        assert!((first(0) - radius(1, 0) * 1e-3).abs() < 1e-12 && (first(1) - radius(1, 0) * 1e-2).abs() < 1e-12);
        let toml = fs::read_to_string(into.join("campaign.toml")).expect("there");
        write(&folder, "trial/campaign.toml", toml.replace("unit = \"mm\"", "unit = \"ell\""));
        all_in(&hemline::import::load(&into).expect_err("no unit").to_string(), &["campaign.toml, row 21", "“ell”", "mm, cm"]);
    }

    #[test]
    fn a_design_in_a_workbook_is_read_in_place() {
        let folder = TempDir::new().expect("a folder");
        let into = campaign(&folder);
        fs::remove_file(into.join("design.csv")).expect("there");
        let mut book = Workbook::new();
        let sheet = book.add_worksheet();
        sheet.write_string(0, 0, "Design of spring").expect("a cell");
        for (c, name) in ["run", "stiff", "profile"].into_iter().enumerate() {
            sheet.write_string(2, c as u16, name).expect("a cell");
        }
        for run in 1..=4_u32 {
            sheet.write_number(run + 2, 0, run).expect("a cell");
            sheet.write_number(run + 2, 1, if run % 2 == 0 { 1 } else { -1 }).expect("a cell");
            sheet.write_string(run + 2, 2, "all.csv").expect("a cell");
        }
        book.save(into.join("design.xlsx")).expect("writable");
        write(&folder, "trial/all.csv", long(&[1, 2, 3, 4]));
        let imported = hemline::import::load(&into).unwrap_or_else(|e| panic!("{e}"));
        let levels: Vec<f64> = imported.campaign.design.runs.iter().map(|run| run.levels[0]).collect();
        assert_eq!((levels, imported.profiles.iter().flatten().count()), (vec![-1.0, 1.0, -1.0, 1.0], 4));
    }

    #[test]
    fn the_workbook_of_init_is_filled_in_imported_and_loads() {
        for kind in ["--workbook", "--workbook=sheets"] {
            let folder = TempDir::new().expect("a folder");
            let dir = folder.path().join("spring");
            let at = dir.to_str().expect("text");
            let written = hemline(&["init", at, "--factors", "stiff", "--replicates", "2", kind]);
            assert!(written.status.success(), "{}", said(&written));
            let toml = fs::read_to_string(dir.join("campaign.toml")).expect("there");
            let toml = toml.replace("title = \"\"", "title = \"t\"").replace("origin = \"\"", "origin = \"o\"");
            let toml = toml.replace("waist_radius_cm = 0", "waist_radius_cm = 9").replace("hem_radius_cm = 0", "hem_radius_cm = 24");
            let toml = toml
                .replace("slant_length_cm = 0", "slant_length_cm = 30")
                .replace("low = 0 ", "low = 5 ")
                .replace("high = 0 ", "high = 20 ");
            write(&folder, "spring/campaign.toml", &toml);
            // An empty workbook has nothing to import but its design, and says so.
            let book = dir.join("workbook.xlsx");
            let empty = hemline(&["import", book.to_str().expect("text"), "--into", at, "--dry-run"]);
            all_in(&said(&empty), &["design of 4 runs", "0 profile(s)"]);
            fill_in(&book);
            let import = || hemline(&["import", book.to_str().expect("text"), "--into", at]);
            let first = import();
            assert_eq!(first.status.code(), Some(0), "{}", said(&first));
            all_in(&said(&first), &["4 profile(s)", "changed profiles.parquet", "design.csv"]);
            let imported = hemline::import::load(&dir).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(imported.profiles.iter().flatten().count(), 4);
            assert_eq!(imported.campaign.design.runs[0].fabric.areal_density.map(|d| d.0), Some(0.15));
            for (run, profile) in imported.campaign.design.runs.iter().zip(&imported.profiles) {
                let expected = hem(run.id.parse().expect("a number"));
                assert!(farthest(profile.as_ref().expect("read").points(), &expected) < 1e-6);
            }
            all_in(&said(&import()), &["nothing changed"]);
        }
    }

    /// Writes the workbook again with what a laboratory would type into it.
    fn fill_in(path: &Path) {
        use calamine::{Data, Reader};
        let mut template: calamine::Xlsx<_> = calamine::open_workbook(path).expect("a workbook");
        let mut book = Workbook::new();
        for name in template.sheet_names().to_owned() {
            let range = template.worksheet_range(&name).expect("a sheet");
            let sheet = book.add_worksheet();
            sheet.set_name(&name).expect("a name");
            for (r, c, value) in range.used_cells() {
                match value {
                    Data::Float(value) => sheet.write_number(r as u32, c as u16, *value),
                    other => sheet.write_string(r as u32, c as u16, other.to_string()),
                }
                .expect("a cell");
            }
            let mut points = |runs: &[u32], column: u16| {
                let mut row = 1;
                for &run in runs {
                    for a in angles() {
                        if column == 1 {
                            sheet.write_number(row, 0, run).expect("a cell");
                        }
                        for (v, c) in xy(run, a).iter().zip(column..) {
                            sheet.write_number(row, c, *v).expect("a cell");
                        }
                        row += 1;
                    }
                }
            };
            match name.strip_prefix("run ") {
                Some(run) => points(&[run.parse().expect("a number")], 0),
                None if name == "Profiles" => points(&[1, 2, 3, 4], 1),
                None if name == "Design" => {
                    for row in 1..=4 {
                        sheet.write_number(row, 3, 150).expect("a cell");
                    }
                }
                None => (),
            }
        }
        book.save(path).expect("writable");
    }

    #[test]
    fn a_kill_at_any_moment_leaves_the_old_campaign_or_the_new_one() {
        let folder = TempDir::new().expect("a folder");
        let into = campaign(&folder);
        let at = into.to_str().expect("text").to_owned();
        let old = write(&folder, "old/1.csv", polar("angle_deg,radius_cm", |a, r| format!("{a},{r}")));
        tidy::plan(&[old], &into, &Options::default()).and_then(|plan| plan.write()).expect("imports");
        let store = || ["profiles.parquet", "quarantine.csv"].map(|name| fs::read(into.join(name)).expect("there"));
        let before = store();
        for i in 0..60 {
            write(
                &folder,
                &format!("new/{}.csv", 100 + i),
                polar("angle_deg,radius_cm", |a, r| format!("{a},{}", r + 0.1 * f64::from(i + 1))) + "1,x\n",
            );
        }
        let new = folder.path().join("new");
        let import = || {
            Command::new(env!("CARGO_BIN_EXE_hemline"))
                .args(["import", new.to_str().expect("text"), "--into", &at])
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .expect("starts")
        };
        let plan = tidy::plan(std::slice::from_ref(&new), &into, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
        let start = Instant::now();
        assert_eq!(import().wait().expect("ends").code(), Some(1));
        let whole = start.elapsed();
        let after = store();
        assert!(before != after && plan.total == 61);
        let (mut old, mut changed) = (0, 0);
        for kill in 0..16_u32 {
            ["profiles.parquet", "quarantine.csv"]
                .iter()
                .zip(&before)
                .for_each(|(name, bytes)| fs::write(into.join(name), bytes).expect("writable"));
            let mut child = import();
            std::thread::sleep(whole.mul_f64(f64::from(kill) / 15.0).min(Duration::from_secs(5)));
            let _ = child.kill();
            let _ = child.wait();
            // Whoever opens the campaign next sees one or the other.
            hemline::import::load(&into).unwrap_or_else(|e| panic!("{e}"));
            let found = store();
            assert!(found == before || found == after, "killed after {kill}/15 of {whole:?}");
            if found == before { old += 1 } else { changed += 1 }
        }
        println!("16 kills within {whole:?}: {old} left the old state, {changed} the new one");
        assert!(0 < old);
        import().wait().expect("ends");
        assert!(store() == after);
        let left: Vec<String> =
            fs::read_dir(&into).expect("a folder").map(|f| f.expect("readable").file_name().to_string_lossy().into_owned()).collect();
        assert!(left.iter().all(|name| !name.starts_with('.')), "{left:?}");
        let mut magic = [0; 4];
        fs::File::open(into.join("profiles.parquet")).and_then(|mut file| file.read_exact(&mut magic)).expect("there");
        assert_eq!(&magic, b"PAR1");
    }
}
