//! A command profile written on the command line: `shape,key=value,...`.

use sealegs::actuator::excitation::Profile;
use serde::Deserialize;

use crate::failure::{OrBadInput, bad_input};

/// Reads one profile; `column` is where a table's values are found unless it says otherwise.
///
/// # Errors
///
/// Bad input, naming the part at fault.
pub fn parse(text: &str, column: &str) -> anyhow::Result<Profile> {
    let fault = |problem: String| bad_input(format!("--excitation '{text}': {problem}"));
    let mut parts = text.split(',').map(str::trim);
    let shape = parts.next().unwrap_or_default();
    let mut table = toml::Table::new();
    for part in parts {
        let (key, value) = part.split_once('=').ok_or_else(|| fault(format!("'{part}' is no key=value")))?;
        let (key, value) = (key.trim(), value.trim());
        let value = match (value.parse::<i64>(), value.parse::<f64>(), value.parse::<bool>()) {
            // Whole numbers stay whole for a seed; everything else of a profile is a decimal number.
            (Ok(whole), _, _) if key == "seed" => toml::Value::Integer(whole),
            (_, Ok(number), _) => toml::Value::Float(number),
            (_, _, Ok(flag)) => toml::Value::Boolean(flag),
            _ => toml::Value::String(value.to_owned()),
        };
        if table.insert(key.to_owned(), value).is_some() {
            return Err(fault(format!("'{key}' is given twice")));
        }
    }
    if let (Some(toml::Value::String(file)), "table") = (table.get("file"), shape) {
        let content = std::fs::read_to_string(file).map_err(|e| bad_input(format!("{file}: {e}")))?;
        let column = match table.get("column") {
            Some(toml::Value::String(name)) => name.as_str(),
            _ => column,
        };
        let linear = matches!(table.get("linear"), Some(toml::Value::Boolean(true)));
        return Profile::table_from_csv(&content, column, linear, file).or_bad_input();
    }
    if shape == "noise" || shape == "multisine" {
        table.entry("seed").or_insert(toml::Value::Integer(1));
    }
    table.insert("shape".to_owned(), toml::Value::String(shape.to_owned()));
    let profile = Profile::deserialize(table).map_err(|e| fault(e.to_string().trim().to_owned()))?;
    profile.validate().map_err(|e| fault(e.to_string()))?;
    Ok(profile)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_read_and_faults_are_named() {
        assert_eq!(
            parse("sine, amplitude=2, frequency_hz=5", "current_a").expect("good"),
            Profile::Sine { amplitude: 2.0, frequency_hz: 5.0, phase_rad: 0.0 }
        );
        assert_eq!(
            parse("noise,rms=1,bandwidth_hz=150,seed=7", "current_a").expect("good"),
            Profile::Noise { rms: 1.0, bandwidth_hz: 150.0, seed: 7 }
        );
        for (text, part) in [
            ("sine,amplitude", "no key=value"),
            ("sin,amplitude=1", "sin"),
            ("sine,amplitude=1,frequency_hz=-5", "frequency_hz"),
            ("sine,amplitude=1,amplitude=2", "twice"),
            ("table,file=/does/not/exist.csv", "exist.csv"),
            ("", "''"),
        ] {
            let message = parse(text, "current_a").expect_err(text).to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
