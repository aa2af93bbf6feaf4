//! What a campaign wants checked, within which limits, and which failures it knows of.

use serde::{Deserialize, Serialize};

/// One kind of question that `hemline check` asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// Has the run a fit, and was everything that belongs to it usable?
    Fitted,
    /// Do replicates scatter alike in all cells? (Cochran; Brown–Forsythe where cells are unequal.)
    Reproducibility,
    /// Do the significant terms alone meet the cell means? (Fisher.)
    Adequacy,
    /// Are the residuals normal? (Shapiro–Wilk.)
    Normality,
    /// Are residuals of neighbours in run order unrelated? (Durbin–Watson.)
    Independence,
    /// Are the measured points near the predicted hem?
    TheoryRms,
    /// Are predicted and fitted fold depth alike?
    TheoryFoldDepth,
    /// Are predicted and fitted mean radius alike?
    TheoryMeanRadius,
    /// Are predicted and fitted fold count alike?
    TheoryFoldCount,
    /// Is every estimate where the baseline has it?
    Drift,
}

impl Question {
    /// Every question, in the order of a report.
    pub const ALL: [Question; 10] = [
        Question::Fitted,
        Question::Reproducibility,
        Question::Adequacy,
        Question::Normality,
        Question::Independence,
        Question::TheoryRms,
        Question::TheoryFoldDepth,
        Question::TheoryMeanRadius,
        Question::TheoryFoldCount,
        Question::Drift,
    ];

    /// As `campaign.toml` and the results spell it.
    pub fn name(self) -> &'static str {
        match self {
            Question::Fitted => "fitted",
            Question::Reproducibility => "reproducibility",
            Question::Adequacy => "adequacy",
            Question::Normality => "normality",
            Question::Independence => "independence",
            Question::TheoryRms => "theory_rms",
            Question::TheoryFoldDepth => "theory_fold_depth",
            Question::TheoryMeanRadius => "theory_mean_radius",
            Question::TheoryFoldCount => "theory_fold_count",
            Question::Drift => "drift",
        }
    }

    /// Whether it is asked of each response; otherwise it is asked of each run (and drift of every estimate).
    pub fn of_responses(self) -> bool {
        matches!(self, Question::Reproducibility | Question::Adequacy | Question::Normality | Question::Independence)
    }
}

/// A failure that the campaign knows of and accepts, with the reason.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Expected {
    pub question: Question,
    /// The responses or runs that it speaks of, as the campaign names them.
    pub subjects: Vec<String>,
    /// Why this is accepted; shown wherever the failure is.
    pub reason: String,
    /// Line of `campaign.toml`.
    pub row: usize,
}

/// Limits of the checks; what has no limit is not asked.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckRules {
    /// Level of the tests of responses.
    pub alpha: f64,
    /// Names of the responses whose tests and coefficients are checked.
    pub responses: Vec<String>,
    /// Largest move of an estimate away from the baseline, in its own standard errors.
    pub drift: f64,
    /// Largest root mean square distance of a run's points from its predicted hem, m.
    pub theory_rms: Option<f64>,
    /// Largest difference of predicted and fitted fold depth, m.
    pub theory_fold_depth: Option<f64>,
    /// Largest difference of predicted and fitted mean radius, m.
    pub theory_mean_radius: Option<f64>,
    /// Largest difference of predicted and fitted fold count.
    pub theory_fold_count: Option<u32>,
    pub expected: Vec<Expected>,
}

impl CheckRules {
    /// Where nothing is said: the level and the responses of the analysis; a move by a whole standard error is the first that could change a
    /// conclusion; theory is not asked, because how near is near enough only the laboratory knows.
    pub fn usual(alpha: f64, responses: Vec<String>) -> Self {
        CheckRules {
            alpha,
            responses,
            drift: 1.0,
            theory_rms: None,
            theory_fold_depth: None,
            theory_mean_radius: None,
            theory_fold_count: None,
            expected: Vec::new(),
        }
    }
}
