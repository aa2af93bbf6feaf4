//! The entry in `campaign.toml` that points at the store: put in where it is missing, the rest of the text as the user wrote it.

use std::path::Path;

use crate::error::{Error, Place};

/// Where the profiles go unless `campaign.toml` says otherwise.
pub const DEFAULT_STORE: &str = "profiles.parquet";

/// Whether the text names a file of profiles.
pub fn has_entry(text: &str) -> bool {
    text.parse::<toml::Table>().is_ok_and(|table| table.get("profiles").and_then(|profiles| profiles.get("file")).is_some())
}

/// The text with the entry.
///
/// # Errors
/// [`Error::Input`] if `[profiles]` is written in a way that leaves no place for a line.
pub fn with_entry(path: &Path, text: &str) -> Result<String, Error> {
    if has_entry(text) {
        return Ok(text.to_owned());
    }
    let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let entry = format!("file = \"{DEFAULT_STORE}\"   # what `hemline import` read{end}");
    let mut written = String::with_capacity(text.len() + entry.len() + 20);
    let mut placed = false;
    for line in text.split_inclusive('\n') {
        written.push_str(line);
        let bare = line.split('#').next().unwrap_or("").replace([' ', '\t', '\r', '\n'], "");
        if !placed && bare == "[profiles]" {
            if !line.ends_with('\n') {
                written.push_str(end);
            }
            written.push_str(&entry);
            placed = true;
        }
    }
    if !placed {
        if !written.is_empty() && !written.ends_with('\n') {
            written.push_str(end);
        }
        written.push_str(&format!("{end}[profiles]{end}{entry}"));
    }
    if has_entry(&written) {
        return Ok(written);
    }
    let problem = "there is no place for the line that names the imported profiles";
    Err(Error::input(Place::file(path), problem, format!("write file = \"{DEFAULT_STORE}\" under [profiles] yourself")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entered(text: &str) -> String {
        with_entry(Path::new("campaign.toml"), text).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn the_users_text_stays_and_one_line_comes() {
        let text = "title = \"a\"  # mine\n\n [profiles] # pictures\nobject = \"dark\"\n\n[check]\nalpha = 0.05\n";
        let written = entered(text);
        let without: String = written.split_inclusive('\n').filter(|line| !line.starts_with("file = ")).collect();
        assert_eq!(without, text);
        assert!(has_entry(&written));
        assert_eq!(entered(&written), written);
    }

    #[test]
    fn a_missing_section_is_added_at_the_end_with_the_line_ends_of_the_file() {
        assert_eq!(
            entered("title = \"a\""),
            format!("title = \"a\"\n\n[profiles]\nfile = \"{DEFAULT_STORE}\"   # what `hemline import` read\n")
        );
        assert!(entered("title = \"a\"\r\n").ends_with("[profiles]\r\nfile = \"profiles.parquet\"   # what `hemline import` read\r\n"));
    }

    #[test]
    fn an_inline_section_is_left_to_its_owner() {
        let refused = with_entry(Path::new("campaign.toml"), "profiles = { object = \"dark\" }\n").expect_err("no place");
        assert!(refused.to_string().contains("write file"), "{refused}");
    }
}
