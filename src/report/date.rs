//! The date a document bears: given from outside as seconds since 1970, never read from a clock.

use serde::Serialize;

/// A day of the Gregorian calendar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Date {
    pub year: i32,
    pub month: u8,
    pub day: u8,
}

impl Date {
    /// The UTC day that holds a moment, seconds since 1970-01-01.
    ///
    /// Source: Hinnant, “chrono-compatible low-level date algorithms”, `civil_from_days`.
    pub fn from_epoch(seconds: i64) -> Self {
        // Eras of 400 years that begin on 1 March, so the leap day is the last of its year.
        let days = seconds.div_euclid(86_400) + 719_468;
        let era = days.div_euclid(146_097);
        let day_of_era = days.rem_euclid(146_097);
        let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
        let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let shifted_month = (5 * day_of_year + 2) / 153;
        let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
        let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
        let year = year_of_era + era * 400 + i64::from(month <= 2);
        Date { year: year as i32, month: month as u8, day: day as u8 }
    }

    /// The day that the environment asks for by `SOURCE_DATE_EPOCH`; `None` if it asks for none.
    pub fn from_environment() -> Option<Self> {
        std::env::var("SOURCE_DATE_EPOCH").ok()?.trim().parse().ok().map(Self::from_epoch)
    }
}

impl std::fmt::Display for Date {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_moments_fall_on_their_days() {
        // `date -u -d @N +%F`
        for (seconds, day) in [(0, "1970-01-01"), (951_782_400, "2000-02-29"), (1_709_251_199, "2024-02-29"), (-1, "1969-12-31")] {
            assert_eq!(Date::from_epoch(seconds).to_string(), day);
        }
    }
}
