//! Import: what laboratories and cameras hand over becomes profiles in metres; what cannot is located, named and set aside.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hemline::experiment::campaign::{Folds, HemLength, PictureScale, Pictures, Shade, USUAL_RESPONSES};
use hemline::experiment::{Apparatus, Point};
use hemline::import::{self, Imported, image, table};
use hemline::model::hem::{Hem, Placement};
use hemline::units::Metre;
use tempfile::TempDir;

const HEM: Hem = Hem { p: 0.13, q: 0.04, s: 0.008, folds: 5 };

fn project() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Text of a profile table in centimetres.
fn table_of(points: &[Point]) -> String {
    let mut text = String::from("x_cm,y_cm\n");
    points.iter().for_each(|p| text.push_str(&format!("{:.4},{:.4}\n", 100.0 * p.x, 100.0 * p.y)));
    text
}

fn write(folder: &TempDir, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
    fs::write(&path, text).expect("writable");
    path
}

/// A campaign of two factors in two replicates, `design` and `toml` changed by the caller.
fn campaign(change: impl FnOnce(&mut String, &mut String)) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let mut toml = String::from(
        "title = \"trial\"\norigin = \"made for a test\"\napparatus = \"skirt\"\n\n[geometry]\nwaist_radius_cm = 9\nhem_radius_cm = { column = \"hem_radius_cm\" }\nslant_length_cm = 50\n\n\
         [cloth]\nareal_density_g_m2 = { column = \"areal_density_g_m2\" }\n\n\
         [[factors]]\nname = \"stiff\"\nlow = 5\nhigh = 20\n\n[[factors]]\nname = \"wide\"\nunit = \"cm\"\nlow = 20\nhigh = 26\n",
    );
    let mut design = String::from("run,replicate,stiff,wide,areal_density_g_m2,hem_radius_cm,profile\n");
    for run in 1..=8 {
        let (stiff, wide) = (if run % 2 == 0 { 1 } else { -1 }, if run % 4 < 2 { 1 } else { -1 });
        design.push_str(&format!("{run},{},{stiff},{wide},{},20,profiles/run_{run}.csv\n", 1 + (run - 1) / 4, 150 + run));
        let placement = Placement { x0: 0.01, y0: 0.02 * f64::from(run), phase: 0.3 * f64::from(run) };
        write(&folder, &format!("profiles/run_{run}.csv"), table_of(&HEM.outline(&placement, 120)));
    }
    change(&mut toml, &mut design);
    write(&folder, "campaign.toml", toml);
    write(&folder, "design.csv", design);
    folder
}

fn load(folder: &TempDir) -> Imported {
    import::load(folder.path()).unwrap_or_else(|e| panic!("{e}"))
}

fn refusal(folder: &TempDir) -> String {
    import::load(folder.path()).expect_err("should be refused").to_string()
}

/// Ids of the runs that have a usable profile.
fn usable(imported: &Imported) -> Vec<&str> {
    let runs = imported.campaign.design.runs.iter().zip(&imported.profiles);
    runs.filter(|(_, profile)| profile.is_some()).map(|(run, _)| run.id.as_str()).collect()
}

/// The one thing that was set aside, as the user reads it.
fn only_fault(imported: &Imported) -> String {
    assert_eq!(imported.quarantine.len(), 1, "{:#?}", imported.quarantine);
    imported.quarantine[0].to_string()
}

fn all_in(text: &str, parts: &[&str]) {
    parts.iter().for_each(|part| assert!(text.contains(part), "“{part}” is not in: {text}"));
}

mod campaigns {
    use super::*;

    #[test]
    fn the_shipped_campaign_is_read_whole() {
        let imported = import::load(&project().join("data")).unwrap_or_else(|e| panic!("{e}"));
        let campaign = &imported.campaign;
        assert_eq!(imported.quarantine, []);
        assert_eq!(imported.notes, Vec::<String>::new());
        assert_eq!((campaign.design.runs.len(), imported.profiles.iter().flatten().count()), (40, 40));
        assert_eq!((campaign.apparatus, campaign.folds, campaign.hem_length), (Apparatus::Skirt, Folds::default(), HemLength::Auto));
        assert!(campaign.origin.contains("not measured"));
        for (run, profile) in campaign.design.runs.iter().zip(imported.profiles.iter().flatten()) {
            assert_eq!(profile.points().len(), 180);
            assert!(!profile.was_scattered(), "run {}", run.id);
        }
        // First row of data/design.csv: 19.62 µN·m, 147.8 g/m², hem radius 26 cm, levels +1, −1, +1.
        let run = &campaign.design.runs[0];
        assert_eq!(run.levels, [1.0, -1.0, 1.0]);
        let skirt = run.skirt.expect("the cut is known");
        assert!(
            (skirt.hem_radius().0 - 0.26).abs() < 1e-15
                && (skirt.waist_radius().0 - 0.121).abs() < 1e-15
                && (skirt.slant_length().0 - 0.53).abs() < 1e-15
        );
        assert!((run.fabric.flexural_rigidity.expect("measured").0 - 19.62e-6).abs() < 1e-18);
        assert!((run.fabric.areal_density.expect("measured").0 - 0.1478).abs() < 1e-15);
        assert_eq!(imported.sources.len(), 42);
    }

    #[test]
    fn shuffled_points_of_the_shipped_skirts_find_their_order_again() {
        let imported = import::load(&project().join("data")).unwrap_or_else(|e| panic!("{e}"));
        for (run, profile) in imported.campaign.design.runs.iter().zip(imported.profiles.iter().flatten()) {
            let n = profile.points().len();
            // 77 is coprime to 180: every point once, no two neighbours left together.
            let shuffled: Vec<Point> = (0..n).map(|i| profile.points()[77 * i % n]).collect();
            let again = hemline::experiment::DrapeProfile::new(&shuffled).expect("the same points");
            assert!(again.was_scattered());
            let length = |points: &[Point]| (0..n).map(|i| points[i].distance(points[(i + 1) % n])).sum::<f64>();
            // Digitiser noise of 0.5 mm on 8 mm spacing: the order is the shortest tour but for neighbours at a crest.
            assert!(length(again.points()) <= 1.001 * length(profile.points()), "run {}", run.id);
        }
    }

    #[test]
    fn a_sound_campaign_leaves_nothing_in_quarantine() {
        let imported = load(&campaign(|_, _| ()));
        assert_eq!(imported.quarantine, []);
        assert_eq!(usable(&imported), ["1", "2", "3", "4", "5", "6", "7", "8"]);
        assert_eq!(imported.campaign.responses, USUAL_RESPONSES);
        assert_eq!(imported.campaign.alpha, 0.05);
    }

    #[test]
    fn natural_levels_are_coded() {
        let folder = campaign(|toml, design| {
            *toml = toml.replace("low = 20\nhigh = 26\n", "low = 20\nhigh = 26\nlevels = \"natural\"\n");
            let natural = |line: &str| {
                let mut cells: Vec<&str> = line.split(',').collect();
                cells[3] = match cells[3] {
                    "-1" => "20.0",
                    "1" => "26",
                    header => header,
                };
                cells.join(",") + "\n"
            };
            *design = design.lines().map(natural).collect();
        });
        let imported = load(&folder);
        assert_eq!(imported.quarantine, []);
        assert_eq!(imported.campaign.design.runs[1].levels, [1.0, -1.0]);
        assert_eq!(imported.campaign.design.runs[3].levels, [1.0, 1.0]);
    }

    #[test]
    fn every_analysis_key_is_read() {
        let folder = campaign(|toml, _| {
            toml.push_str(
                "\n[analysis]\nresponses = [\"q\", \"m\"]\nalpha = 0.01\nfolds = { from = 3, to = 12 }\nhem_length_cm = 125.5\ngravity_m_s2 = 9.80665\nfoundation_modulus_n_m3 = 20\n\
                 [profiles]\nscale_mm_per_px = 1.383\nobject = \"dark\"\n",
            );
        });
        let campaign = load(&folder).campaign;
        assert_eq!(campaign.responses, ["q", "m"]);
        assert_eq!((campaign.alpha, campaign.gravity, campaign.foundation_modulus), (0.01, 9.80665, 20.0));
        assert_eq!(campaign.folds, Folds::Among { from: 3, to: 12 });
        assert_eq!(campaign.hem_length, HemLength::Held(125.5 * 0.01));
        assert_eq!(
            campaign.pictures,
            Some(Pictures { object: Shade::Dark, ..Pictures::of_scale(PictureScale::Pixel(Metre(1.383 * 1e-3))) })
        );
    }

    #[test]
    fn an_unknown_key_names_the_nearest_known_one_and_its_row() {
        let text = refusal(&campaign(|toml, _| *toml = toml.replace("origin =", "orgin =")));
        all_in(&text, &["campaign.toml, row 2", "“orgin”", "did you mean “origin”"]);
        let text = refusal(&campaign(|toml, _| *toml = toml.replace("waist_radius_cm", "waste_radius_cm")));
        all_in(&text, &["row 6", "“waste_radius_cm”", "did you mean “waist_radius_cm”"]);
        let text = refusal(&campaign(|toml, _| toml.push_str("\n[analysis]\nresponses = [\"fold_dept\"]\n")));
        all_in(&text, &["“fold_dept”", "did you mean “fold_depth”"]);
    }

    #[test]
    fn keys_with_impossible_values_are_refused_with_their_row() {
        for (from, to, parts) in [
            ("waist_radius_cm = 9", "waist_radius_cm = -9", ["row 6", "“waist_radius_cm” is -9", "positive"]),
            ("waist_radius_cm = 9", "waist_radius_cm = \"nine\"", ["row 6", "number", "column"]),
            ("low = 5", "low = 50", ["row 13", "low = 50", "less than high"]),
            ("apparatus = \"skirt\"", "apparatus = \"hat\"", ["row 3", "hat", "drapemeter"]),
            ("slant_length_cm = 50\n", "", ["[geometry] has no slant_length", "slant_length_cm", "column"]),
            ("title = \"trial\"", "title = \" \"", ["row 1", "“title” is empty", "write"]),
            ("title = \"trial\"", "title = trial", ["row 1", "campaign.toml", "init"]),
        ] {
            all_in(&refusal(&campaign(|toml, _| *toml = toml.replace(from, to))), &parts);
        }
    }

    #[test]
    fn an_unknown_column_is_refused_with_the_columns_there_are() {
        let text = refusal(&campaign(|toml, _| *toml = toml.replace("column = \"areal_density_g_m2\"", "column = \"density_g_m2\"")));
        all_in(&text, &["design.csv, row 1", "unknown column", "“density_g_m2”", "did you mean “areal_density_g_m2”", "“stiff”"]);
        let text = refusal(&campaign(|_, design| *design = design.replace("stiff", "stif")));
        all_in(&text, &["unknown column", "“stiff”", "did you mean “stif”"]);
    }

    #[test]
    fn a_column_in_another_unit_than_its_key_is_refused() {
        let text = refusal(&campaign(|toml, _| *toml = toml.replace("hem_radius_cm = {", "hem_radius_mm = {")));
        all_in(&text, &["mixed units", "“hem_radius_mm”", "“hem_radius_cm”", "row 7"]);
    }

    #[test]
    fn a_missing_run_is_named_and_the_others_go_on() {
        let imported =
            load(&campaign(|_, design| *design = design.lines().filter(|l| !l.starts_with("5,")).map(|l| format!("{l}\n")).collect()));
        all_in(&only_fault(&imported), &["run 5", "missing run", "design.csv", "add its row"]);
        assert_eq!(usable(&imported).len(), 7);
        assert!(imported.notes.iter().any(|note| note.contains("unbalanced")));
    }

    #[test]
    fn a_missing_profile_file_is_named_and_the_others_go_on() {
        let folder = campaign(|_, _| ());
        fs::remove_file(folder.path().join("profiles/run_3.csv")).expect("there");
        let imported = load(&folder);
        all_in(&only_fault(&imported), &["run 3", "design.csv, row 4", "profiles/run_3.csv", "no such file", "add the file"]);
        assert_eq!((imported.campaign.design.runs.len(), usable(&imported).len()), (8, 7));
        assert_eq!(imported.profiles[2], None);
    }

    #[test]
    fn a_duplicate_run_is_set_aside_and_the_first_is_used() {
        let imported = load(&campaign(|_, design| design.push_str("2,3,1,1,160,20,profiles/run_2.csv\n")));
        all_in(&only_fault(&imported), &["run 2", "row 10", "duplicate run", "row 3", "delete one"]);
        assert_eq!(usable(&imported).len(), 8);
    }

    #[test]
    fn a_nan_in_the_cloth_is_located_and_the_run_goes_on_without_it() {
        for (value, problem) in [("NaN", "not a finite number"), ("", "is empty"), ("heavy", "not a number"), ("-3", "not positive")] {
            let imported = load(&campaign(|_, design| *design = design.replace(",154,", &format!(",{value},"))));
            all_in(&only_fault(&imported), &["run 4", "row 5", "“areal_density_g_m2”", value, problem, "goes on without"]);
            assert_eq!(usable(&imported).len(), 8);
            assert_eq!(imported.campaign.design.runs[3].fabric.areal_density, None);
        }
    }

    #[test]
    fn a_level_that_is_none_sets_its_run_aside() {
        for (value, parts) in [
            ("0.5", ["no level", "−1 or 1, or 0"]),
            ("", ["is empty", "set aside"]),
            ("high", ["not a number", "set aside"]),
            ("20", ["natural level", "levels = \"natural\""]),
        ] {
            let imported = load(&campaign(|_, design| *design = design.replace("\n6,2,1,", &format!("\n6,2,{value},"))));
            let fault = only_fault(&imported);
            all_in(&fault, &["run 6", "row 7", "“stiff”"]);
            all_in(&fault, &parts);
            assert_eq!(usable(&imported), ["1", "2", "3", "4", "5", "7", "8"]);
        }
    }

    #[test]
    fn zero_in_all_factors_is_a_centre_point_and_in_some_a_fault() {
        let centred = |from: &'static str, to: &'static str| {
            load(&campaign(move |_, design| {
                assert!(design.contains(from), "{design}");
                *design = design.replace(from, to);
            }))
        };
        let imported = centred("\n6,2,1,-1,", "\n6,2,0,0,");
        assert!(imported.quarantine.is_empty(), "{:?}", imported.quarantine);
        assert_eq!(imported.campaign.design.runs[5].levels, [0.0, 0.0]);
        let imported = centred("\n6,2,1,-1,", "\n6,2,0,-1,");
        all_in(&only_fault(&imported), &["run 6", "row 7", "0, -1", "at the centre in some factors", "correct the levels"]);
        assert_eq!(usable(&imported), ["1", "2", "3", "4", "5", "7", "8"]);
    }

    #[test]
    fn a_three_point_profile_is_set_aside() {
        let folder = campaign(|_, _| ());
        write(&folder, "profiles/run_7.csv", "x_cm,y_cm\n1,0\n0,1\n-1,0\n");
        let imported = load(&folder);
        all_in(&only_fault(&imported), &["run 7", "run_7.csv", "3 points", "at least 12", "whole outline"]);
        assert_eq!(usable(&imported).len(), 7);
    }

    #[test]
    fn mixed_units_in_a_profile_set_it_aside() {
        let folder = campaign(|_, _| ());
        let text = fs::read_to_string(folder.path().join("profiles/run_1.csv")).expect("there");
        write(&folder, "profiles/run_1.csv", text.replace("y_cm", "y_mm"));
        let imported = load(&folder);
        all_in(&only_fault(&imported), &["run 1", "run_1.csv, row 1", "mixed units", "“x_cm”", "“y_mm”", "one unit"]);
        assert_eq!(usable(&imported).len(), 7);
    }

    #[test]
    fn a_broken_picture_is_one_sentence_and_the_others_go_on() {
        let scaled = |toml: &mut String, design: &mut String| {
            toml.push_str("\n[profiles]\nscale_mm_per_px = 1\n");
            *design = design.replace("run_8.csv", "run_8.png");
        };
        let mut sound = Vec::new();
        silhouette(&HEM, 256, 0.0, false).write_to(&mut std::io::Cursor::new(&mut sound), ::image::ImageFormat::Png).expect("encodes");
        for bytes in [b"not a picture at all".to_vec(), sound[..sound.len() / 3].to_vec(), Vec::new()] {
            let folder = campaign(scaled);
            write(&folder, "profiles/run_8.png", bytes);
            let imported = load(&folder);
            let fault = only_fault(&imported);
            all_in(&fault, &["run 8", "run_8.png", "the picture cannot be read", "save it again"]);
            assert!(!fault.contains('\n'));
            assert_eq!(usable(&imported).len(), 7);
        }
    }

    #[test]
    fn a_picture_without_a_scale_is_set_aside_with_the_key_to_add() {
        let folder = campaign(|_, design| *design = design.replace("run_8.csv", "run_8.png"));
        silhouette(&HEM, 256, 0.0, false).save(folder.path().join("profiles/run_8.png")).expect("writable");
        all_in(&only_fault(&load(&folder)), &["run 8", "scale_mm_per_px"]);
    }

    #[test]
    fn a_path_out_of_the_folder_is_data_and_not_followed() {
        for path in ["../elsewhere.csv", "/etc/passwd"] {
            let imported = load(&campaign(|_, design| *design = design.replace("profiles/run_2.csv", path)));
            all_in(&imported.quarantine[0].to_string(), &["run 2", "outside the campaign folder", "copy it"]);
        }
    }

    #[test]
    fn runs_may_share_one_file_of_named_profiles() {
        let folder = campaign(|_, design| (1..=8).for_each(|run| *design = design.replace(&format!("run_{run}.csv"), "all.csv")));
        let mut text = String::from("profile;x [mm];y [mm]\n");
        for run in 1..=8 {
            let n = if run == 6 { 5 } else { 60 };
            HEM.outline(&Placement::ORIGIN, n)
                .iter()
                .for_each(|p| text.push_str(&format!("{run};{:.3};{:.3}\n", 1e3 * p.x, 1e3 * p.y).replace('.', ",")));
        }
        write(&folder, "profiles/all.csv", text);
        let imported = load(&folder);
        all_in(&only_fault(&imported), &["run 6", "5 points"]);
        assert_eq!(usable(&imported).len(), 7);
    }

    #[test]
    fn strays_repeats_and_reconstructed_orders_are_noted() {
        let folder = campaign(|_, design| *design = design.replace("run_5.csv", "run_4.csv"));
        let mut lines: Vec<String> =
            fs::read_to_string(folder.path().join("profiles/run_1.csv")).expect("there").lines().map(String::from).collect();
        // 37 is coprime to the 120 rows.
        let rows = lines.split_off(1);
        let shuffled: Vec<String> = (0..120).map(|i| rows[37 * i % 120].clone()).collect();
        write(&folder, "profiles/run_1.csv", format!("{}\n{}\n", lines[0], shuffled.join("\n")));
        let notes = load(&folder).notes.join("\n");
        all_in(&notes, &["run_5.csv", "belong to no run", "runs 4, 5 share", "run 1: the points were not in order"]);
    }

    #[test]
    fn a_campaign_without_one_usable_profile_says_what_is_wrong_with_the_first() {
        let folder = campaign(|_, _| ());
        fs::remove_dir_all(folder.path().join("profiles")).expect("there");
        all_in(&refusal(&folder), &["not one of the 8 runs", "run 1", "profiles/run_1.csv", "no such file"]);
        all_in(&refusal(&TempDir::new().expect("a folder")), &["campaign.toml", "no such file", "hemline init"]);
    }

    #[test]
    fn the_silhouettes_of_the_cusick_set_are_traced_if_they_are_there() {
        let folder = project().join("../shared/data/cusick40/silhouettes");
        let Ok(files) = fs::read_dir(&folder) else {
            println!("skipped: {} is not there", folder.display());
            return;
        };
        let mut count = 0;
        for file in files.map(|f| f.expect("readable").path()).filter(|f| image::is_picture(f)) {
            let silhouette =
                image::outline(&file, &Pictures { object: Shade::Dark, ..Pictures::of_scale(PictureScale::Pixel(Metre(1.383e-3))) })
                    .unwrap_or_else(|e| panic!("{e}"));
            let area: f64 = area(silhouette.profile.points());
            // Between the support disc (18 cm) and the flat specimen (30 cm), with 3 % for the scale, which is stated as about.
            assert!((0.0254 * 0.97..0.0707 * 1.03).contains(&area), "{}: {area} m²", file.display());
            assert!(!silhouette.profile.was_scattered());
            count += 1;
        }
        println!("{count} silhouettes traced");
        assert_eq!(count, 40);
    }
}

fn area(points: &[Point]) -> f64 {
    let next = points.iter().cycle().skip(1);
    0.5 * points.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>()
}

mod tables {
    use super::*;

    fn read(text: impl AsRef<[u8]>) -> Result<table::Table, hemline::Error> {
        let folder = TempDir::new().expect("a folder");
        table::profiles(&write(&folder, "outline.csv", text))
    }

    /// One row per point, as `line` writes it.
    fn rows(header: &str, line: impl Fn(f64, f64) -> String) -> String {
        let points = HEM.outline(&Placement::ORIGIN, 48);
        points.iter().fold(format!("{header}\n"), |text, p| text + &line(p.x, p.y) + "\n")
    }

    fn is_the_hem(table: &table::Table) {
        assert_eq!((table.profiles.len(), table.quarantine.len()), (1, 0), "{:?}", table.quarantine);
        let expected = HEM.outline(&Placement::ORIGIN, 48);
        for (point, expected) in table.profiles[0].profile.points().iter().zip(&expected) {
            // Files are written to a micrometre.
            assert!(point.distance(*expected) < 1.5e-6, "{point:?} {expected:?}");
        }
    }

    #[test]
    fn units_spellings_separators_marks_and_line_ends_are_understood() {
        let decimal_comma = |text: String| text.replace('.', ",");
        for text in [
            rows("x_cm,y_cm", |x, y| format!("{:.4},{:.4}", 100.0 * x, 100.0 * y)),
            rows("x_mm,y_mm", |x, y| format!("{:.3},{:.3}", 1e3 * x, 1e3 * y)),
            rows("X_M,Y_M", |x, y| format!("{x:.6},{y:.6}")),
            rows("x_in,y_in", |x, y| format!("{:.6},{:.6}", x / 0.0254, y / 0.0254)),
            rows("x [cm];y [cm]", |x, y| format!("{:.4};{:.4}", 100.0 * x, 100.0 * y)),
            rows("x (mm)\ty (mm)", |x, y| decimal_comma(format!("{:.3}\t{:.3}", 1e3 * x, 1e3 * y))),
            rows("x, mm;y, mm", |x, y| decimal_comma(format!("{:.3};{:.3}", 1e3 * x, 1e3 * y))),
            rows("x, mm,y, mm", |x, y| format!("{:.3},{:.3}", 1e3 * x, 1e3 * y)),
            rows("y_cm,z_cm,x_cm", |x, y| format!("{:.4},-51.3,{:.4}", 100.0 * y, 100.0 * x)),
            rows("x_cm,y_cm", |x, y| {
                format!("\"{}\",\"{}\"", decimal_comma(format!("{:.4}", 100.0 * x)), decimal_comma(format!("{:.4}", 100.0 * y)))
            }),
            format!(
                "\u{feff}# a comment\n\n{}",
                rows("x_cm,y_cm", |x, y| format!("{:.4},{:.4}\r\n", 100.0 * x, 100.0 * y)).replace("y_cm\n", "y_cm\r\n")
            ),
        ] {
            is_the_hem(&read(&text).unwrap_or_else(|e| panic!("{e}\n{}", &text[..60])));
        }
    }

    #[test]
    fn faulty_rows_are_located_and_the_profile_goes_on() {
        let mut lines: Vec<String> =
            rows("x_cm,y_cm", |x, y| format!("{:.4},{:.4}", 100.0 * x, 100.0 * y)).lines().map(String::from).collect();
        lines[4] = "NaN,1.5".into();
        lines[9] = "1.5,n/a".into();
        lines[14] = "1.5".into();
        lines[19] = "1,5,2,5".into();
        lines[24] = ",2.0".into();
        let table = read(lines.join("\n")).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(table.profiles[0].profile.points().len(), 43);
        let rows: Vec<(Option<usize>, &str)> = table.quarantine.iter().map(|q| (q.row, q.value.as_str())).collect();
        assert_eq!(rows, [(Some(5), "NaN"), (Some(10), "n/a"), (Some(15), "1.5"), (Some(20), "1,5,2,5"), (Some(25), "")]);
        // The rows that the points came from are known: row 2 is the first point.
        let first = &table.profiles[0];
        assert_eq!((first.rows[0], first.rows[3]), (2, 6));
    }

    #[test]
    fn profiles_are_told_apart_by_their_column() {
        let one = rows("profile,x_cm,y_cm", |x, y| format!("left,{:.4},{:.4}", 100.0 * x, 100.0 * y));
        let two = rows("", |x, y| format!("right,{:.4},{:.4}", 100.0 * x, 100.0 * y));
        let table = read(one + &two + "third,1,2\nthird,2,1\n,5,5\n").unwrap_or_else(|e| panic!("{e}"));
        let names: Vec<&str> = table.profiles.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["left", "right"]);
        let faults: Vec<String> = table.quarantine.iter().map(|q| q.to_string()).collect();
        assert_eq!(faults.len(), 2);
        all_in(&faults[0], &["third", "2 points", "at least 12"]);
        all_in(&faults[1], &["“profile” is empty"]);
    }

    #[test]
    fn what_is_no_profile_table_is_refused_with_a_remedy() {
        let sound = rows("x_cm,y_cm", |x, y| format!("{:.4},{:.4}", 100.0 * x, 100.0 * y));
        for (text, parts) in [
            (sound.replace("x_cm,y_cm", "x_cm,y_mm"), ["mixed units", "“x_cm”", "one unit"]),
            (sound.replace("x_cm,y_cm", "x_cm,x_mm"), ["several columns", "“x_mm”", "keep one"]),
            (sound.replace("x_cm,y_cm", "x_cm,height_cm"), ["no column for y", "“height_cm”", "y_cm"]),
            (sound.replace("x_cm,y_cm", "x,y"), ["no unit", "“x”", "x_cm"]),
            (sound.replace("x_cm,y_cm", "x_px,y_px"), ["“px”", "no unit of length", "mm"]),
            (sound.replace("x_cm,y_cm", "x_cm,X_CM"), ["two columns", "X_CM", "own name"]),
            ("x_cm,y_cm\n".into(), ["no rows", "outline.csv", "one row per point"]),
            (String::new(), ["empty", "outline.csv", "header"]),
        ] {
            all_in(&read(text).expect_err("refused").to_string(), &parts);
        }
        all_in(&read([0x50, 0x4b, 3, 4, 0, 0]).expect_err("refused").to_string(), &["the workbook is damaged", "save it again"]);
        all_in(&read(b"x_cm,y_cm\n1,2\n\0\xff\0\x07\n").expect_err("refused").to_string(), &["row 3", "no text file", "save it as CSV"]);
    }

    #[test]
    fn commas_that_read_both_ways_are_refused_and_not_guessed() {
        let text = (0..20).fold(String::from("x_mm;y_mm\n"), |text, i| text + &format!("1,{:03};2,{:03}\n", 100 + 7 * i, 900 - 11 * i));
        all_in(&read(text).expect_err("refused").to_string(), &["decimal comma", "thousands", "write decimal points"]);
    }

    #[test]
    fn forty_tables_of_180_rows_are_read_without_a_noticeable_wait() {
        let folder = project().join("data/profiles");
        let files: Vec<PathBuf> = fs::read_dir(folder).expect("shipped").map(|f| f.expect("readable").path()).collect();
        assert_eq!(files.len(), 40);
        let start = Instant::now();
        let points: usize =
            files.iter().map(|f| table::profiles(f).unwrap_or_else(|e| panic!("{e}")).profiles[0].profile.points().len()).sum();
        println!("{points} rows in {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
        assert_eq!(points, 40 * 180);
    }
}

/// A black hem on white, `side` pixels square, one pixel being one unit of `0.4 m / side`: area coverage by 16 × 16 samples a pixel, then a
/// Gaussian blur of `blur` pixels; inverted if `light`.
fn silhouette(hem: &Hem, side: u32, blur: f64, light: bool) -> ::image::GrayImage {
    shaded(hem, side, blur, |covered, _, _| if light { 30.0 + 200.0 * covered } else { 230.0 - 200.0 * covered })
}

/// As [`silhouette`], the grey value 0…255 given by coverage and place (0…1).
fn shaded(hem: &Hem, side: u32, blur: f64, shade: impl Fn(f64, f64, f64) -> f64) -> ::image::GrayImage {
    let n = side as usize;
    let mut covered = coverage(hem, n);
    if 0.0 < blur {
        let reach = (4.0 * blur).ceil() as isize;
        let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / blur).powi(2)).exp()).collect();
        let total: f64 = weights.iter().sum();
        for along_rows in [true, false] {
            let value = |x: isize, y: isize| covered[(y.clamp(0, n as isize - 1) * n as isize + x.clamp(0, n as isize - 1)) as usize];
            covered = (0..n * n)
                .map(|at| {
                    let (x, y) = ((at % n) as isize, (at / n) as isize);
                    let shifted = |k: isize| if along_rows { value(x + k, y) } else { value(x, y + k) };
                    weights.iter().zip(-reach..).map(|(w, k)| w * shifted(k)).sum::<f64>() / total
                })
                .collect();
        }
    }
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    ::image::GrayImage::from_fn(side, side, |x, y| {
        let value = shade(covered[y as usize * n + x as usize], at(x), at(y));
        ::image::Luma([value.round().clamp(0.0, 255.0) as u8])
    })
}

/// Where the hem lies in its picture.
fn placement() -> Placement {
    Placement { x0: 0.2013, y0: 0.1978, phase: 0.137 }
}

/// Covered share of each pixel: exact in x (crossings of 64 scan lines a pixel with a fine polygon), top row first.
fn coverage(hem: &Hem, n: usize) -> Vec<f64> {
    const LINES: usize = 64;
    let pixel = 0.4 / n as f64;
    let polygon: Vec<[f64; 2]> = hem.outline(&placement(), 40_000).iter().map(|p| [p.x / pixel, n as f64 - p.y / pixel]).collect();
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); n * LINES];
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (low, high) = (a[1].min(b[1]), a[1].max(b[1]));
        let first = (low * LINES as f64 - 0.5).ceil().max(0.0) as usize;
        for (line, found) in crossings.iter_mut().enumerate().skip(first) {
            let y = (line as f64 + 0.5) / LINES as f64;
            if high <= y {
                break;
            }
            found.push(a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]));
        }
    }
    let mut covered = vec![0.0; n * n];
    for (line, found) in crossings.iter_mut().enumerate() {
        found.sort_by(f64::total_cmp);
        for pair in found.chunks_exact(2) {
            for x in (pair[0].max(0.0) as usize)..n.min(pair[1] as usize + 1) {
                let inside = pair[1].min(x as f64 + 1.0) - pair[0].max(x as f64);
                covered[(line / LINES) * n + x] += inside.max(0.0) / LINES as f64;
            }
        }
    }
    covered
}

#[test]
fn damaged_files_are_refused_or_set_aside_and_never_a_panic() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(8);
    let encoded = |format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        silhouette(&HEM, 64, 0.5, false).write_to(&mut bytes, format).expect("encodes");
        bytes.into_inner()
    };
    let pictures = [("a.png", encoded(::image::ImageFormat::Png)), ("a.jpg", encoded(::image::ImageFormat::Jpeg))];
    let text = table_of(&HEM.outline(&Placement::ORIGIN, 30)).into_bytes();
    let sound = campaign(|_, _| ());
    let read = |name: &str| fs::read(sound.path().join(name)).expect("written");
    let (toml, design) = (read("campaign.toml"), read("design.csv"));
    let folder = TempDir::new().expect("a folder");
    // Bytes that mean something to the readers are likelier than others.
    let telling = b"\"\n\r,;\t#-.e=[]{}\0\xff\xef 09";
    for _ in 0..400 {
        let mut damage = |bytes: &[u8]| {
            let mut bytes = bytes.to_vec();
            for _ in 0..random.random_range(1..6) {
                let at = random.random_range(0..bytes.len());
                match random.random_range(0..4) {
                    0 => bytes[at] = random.random(),
                    1 => bytes[at] = telling[random.random_range(0..telling.len())],
                    2 => bytes.insert(at, telling[random.random_range(0..telling.len())]),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            bytes
        };
        for (name, bytes) in &pictures {
            let file = write(&folder, name, damage(bytes));
            let _ = image::outline(&file, &Pictures::of_scale(PictureScale::Pixel(Metre(1e-3))));
        }
        let _ = table::profiles(&write(&folder, "a.csv", damage(&text)));
        write(&sound, "campaign.toml", if random.random() { damage_once(&toml, &mut random) } else { toml.clone() });
        write(&sound, "design.csv", damage_once(&design, &mut random));
        let _ = import::load(sound.path());
    }
}

/// One random byte changed.
fn damage_once(bytes: &[u8], random: &mut rand_chacha::ChaCha8Rng) -> Vec<u8> {
    use rand::RngExt;
    let mut bytes = bytes.to_vec();
    let at = random.random_range(0..bytes.len());
    bytes[at] = random.random();
    bytes
}
