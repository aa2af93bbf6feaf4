//! The theory against the independent shell simulator whose forty runs ship in `data/`: as it is, not as one would wish.

use std::path::Path;

use hemline::import;
use hemline::study::campaign::{Measured, analyse};
use hemline::study::fidelities::{against, summarize};

#[test]
fn graded_shell_comes_nearest_to_the_simulator() {
    let imported = import::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data")).unwrap();
    let measured = Measured {
        campaign: imported.campaign,
        profiles: imported.profiles,
        quarantine: imported.quarantine,
        sources: imported.sources,
        notes: imported.notes,
    };
    let study = analyse(measured, &|| ());
    let rows = against(&study.runs, study.campaign.gravity);
    let summaries = summarize(&rows);
    for s in &summaries {
        println!(
            "{:?} {}: {} runs, folds exact {}, within one {}; {} compared: rms {:.1?} mm, depth ratio {:.2?}, mean radius {:+.1?} mm",
            s.levels,
            s.fidelity,
            s.runs,
            s.exact,
            s.within_one,
            s.compared,
            s.rms.map(|v| v * 1000.0),
            s.depth_ratio,
            s.mean_radius.map(|v| v * 1000.0)
        );
    }
    let of = |name: &str| summaries.iter().find(|s| s.fidelity == name && s.levels.is_none()).unwrap();
    let (graded, ruled, ansatz) = (of("graded"), of("ruled"), of("ansatz"));
    assert_eq!([graded.runs, ruled.runs, ansatz.runs], [40; 3]);
    // The ruled shell lets inner rings be shorter than their cloth, so it hangs too far in; the graded shell corrects part of that.
    assert!(graded.rms.unwrap() < ruled.rms.unwrap());
    assert!(ruled.mean_radius.unwrap() < graded.mean_radius.unwrap() && graded.mean_radius.unwrap() < 0.0);
    assert!(36 <= graded.within_one && ruled.exact <= graded.exact, "{graded:?} {ruled:?}");
}
