//! The date for file headers.

/// `SOURCE_DATE_EPOCH` as YYYY-MM-DD, if it is set: the same input gives the same bytes, so the
/// clock is never read.
pub fn from_environment() -> Option<String> {
    let seconds: i64 = std::env::var("SOURCE_DATE_EPOCH")
        .ok()?
        .trim()
        .parse()
        .ok()?;
    Some(civil(seconds.div_euclid(86_400)))
}

/// Day of the Gregorian calendar, from days since 1970-01-01.
fn civil(days: i64) -> String {
    // Years begin in March, so that the leap day is the last one; 400 years have 146,097 days.
    let days = days + 719_468;
    let (era, day) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    format!("{:04}-{month:02}-{day:02}", year + 400 * era + next)
}

#[cfg(test)]
mod tests {
    use super::civil;

    #[test]
    fn calendar_days() {
        let cases = [
            (0, "1970-01-01"),
            (11_016, "2000-02-29"),
            (11_017, "2000-03-01"),
            (20_453, "2025-12-31"),
            (-1, "1969-12-31"),
        ];
        for (days, text) in cases {
            assert_eq!(civil(days), text);
        }
    }
}
