//! What many runs say alike is sent once: heads of their tables, and texts that come again.

use std::collections::HashMap;

use serde_json::{Value, json};

/// The tables that every run has.
const TABLES: [&str; 2] = ["numbers", "folds"];

/// Texts of fewer letters are as short as what would stand for them.
const SHORTEST: usize = 4;

/// Leaves rows alone of the runs' tables: their heads move to `run_columns`, and a text becomes `[i]`, its place in `texts`. The script puts them back.
pub fn shared(page: &mut Value) {
    let Some(runs) = page["runs"].as_array_mut() else { return };
    let (mut places, mut texts) = (HashMap::new(), vec![]);
    let mut once = |text: &mut Value| {
        if let Some(said) = text.as_str().filter(|said| SHORTEST <= said.chars().count()) {
            let place = *places.entry(said.to_string()).or_insert_with(|| {
                texts.push(said.to_string());
                texts.len() - 1
            });
            *text = json!([place]);
        }
    };
    let mut columns = serde_json::Map::new();
    for run in runs {
        for name in TABLES {
            let table = run[name].take();
            let mut rows = table["rows"].clone();
            rows.as_array_mut().into_iter().flatten().filter_map(Value::as_array_mut).flatten().for_each(&mut once);
            columns.entry(name).or_insert_with(|| table["columns"].clone());
            run[name] = rows;
        }
        run["surfaces"].as_array_mut().into_iter().flatten().for_each(|surface| once(&mut surface["about"]));
    }
    page["run_columns"] = Value::Object(columns);
    page["texts"] = json!(texts);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_comes_again_is_sent_once_and_numbers_stay() {
        let columns = json!([{ "name": "Quantity" }]);
        let run = |value: f64| {
            json!({
                "numbers": { "columns": columns, "rows": [["mean radius p", ["153.1", value], null, "mm"]] },
                "folds": { "columns": [], "rows": [] },
                "surfaces": [{ "about": "mean radius p" }],
            })
        };
        let mut page = json!({ "runs": [run(1.0), run(2.0)] });
        shared(&mut page);
        assert_eq!(page["texts"], json!(["mean radius p"]));
        assert_eq!(page["run_columns"]["numbers"], columns);
        assert_eq!(page["runs"][1]["numbers"], json!([[[0], ["153.1", 2.0], null, "mm"]]));
        assert_eq!(page["runs"][0]["surfaces"][0]["about"], json!([0]));
    }
}
