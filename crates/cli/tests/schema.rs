//! What the verbs write is what their published schemas say, and the published schemas are the present ones.

mod program;

use program::{json, sealegs};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn published() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema")
}

fn succeeds(arguments: &[&str]) {
    let done = sealegs(2, arguments);
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
}

/// Where a value is not what a schema says, one line each. It knows the words that our schemas use, and takes any other for a
/// fault: what it does not check is not called valid. A key that the schema does not name is a fault, too.
fn faults(root: &Value, schema: &Value, value: &Value, at: &str) -> Vec<String> {
    let mut found = Vec::new();
    let Some(words) = schema.as_object() else {
        return if schema == &Value::Bool(true) { found } else { vec![format!("{at}: nothing is allowed")] };
    };
    let mut need = |holds: bool, what: String| {
        if !holds {
            found.push(format!("{at}: {what}, found {value}"));
        }
    };
    let list = |word: &Value| word.as_array().cloned().unwrap_or_default();
    let mut inner = Vec::new();
    for (word, said) in words {
        match word.as_str() {
            "$schema" | "$defs" | "title" | "description" | "format" | "default" => {}
            "type" => {
                let types = if said.is_array() { list(said) } else { vec![said.clone()] };
                let is = |t: &Value| match t.as_str().unwrap_or_default() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "integer" => value.is_u64() || value.is_i64(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    _ => false,
                };
                need(types.iter().any(is), format!("not of type {said}"));
            }
            "const" => need(value == said, format!("not {said}")),
            "enum" => need(list(said).contains(value), format!("none of {said}")),
            "minimum" => need(value.as_f64() >= said.as_f64(), format!("less than {said}")),
            "minItems" => need(
                value.as_array().is_none_or(|v| v.len() as u64 >= said.as_u64().unwrap()),
                "too short".into(),
            ),
            "maxItems" => need(
                value.as_array().is_none_or(|v| v.len() as u64 <= said.as_u64().unwrap()),
                "too long".into(),
            ),
            "required" => {
                for key in list(said) {
                    need(value.get(key.as_str().unwrap()).is_some(), format!("{key} is missing"));
                }
            }
            "properties" => {
                for (key, of) in said.as_object().unwrap() {
                    if let Some(value) = value.get(key) {
                        inner.extend(faults(root, of, value, &format!("{at}/{key}")));
                    }
                }
                if !words.contains_key("additionalProperties") {
                    let known = |key: &String| said.get(key).is_some();
                    let unknown: Vec<&String> =
                        value.as_object().into_iter().flat_map(|o| o.keys()).filter(|k| !known(k)).collect();
                    need(unknown.is_empty(), format!("{unknown:?} are not in the schema"));
                }
            }
            "additionalProperties" => {
                let named = words.get("properties");
                for (key, value) in value.as_object().into_iter().flatten() {
                    if named.is_none_or(|p| p.get(key).is_none()) {
                        inner.extend(faults(root, said, value, &format!("{at}/{key}")));
                    }
                }
            }
            "items" => {
                for (i, value) in value.as_array().into_iter().flatten().enumerate() {
                    inner.extend(faults(root, said, value, &format!("{at}/{i}")));
                }
            }
            "prefixItems" => {
                for (i, (of, value)) in
                    list(said).iter().zip(value.as_array().into_iter().flatten()).enumerate()
                {
                    inner.extend(faults(root, of, value, &format!("{at}/{i}")));
                }
            }
            "anyOf" | "oneOf" => {
                let fits = list(said).iter().filter(|of| faults(root, of, value, at).is_empty()).count();
                let right = if word == "oneOf" { fits == 1 } else { fits > 0 };
                need(right, format!("fits {fits} of {word} {said}"));
            }
            "$ref" => {
                let path = said.as_str().unwrap().strip_prefix('#').unwrap();
                let of = root.pointer(path).unwrap_or_else(|| panic!("no {path}"));
                inner.extend(faults(root, of, value, at));
            }
            other => panic!("{at}: '{other}' is not checked by this test"),
        }
    }
    found.extend(inner);
    found
}

fn valid(schema: &str, result: &Path) {
    let (schema, result) = (json(&published().join(schema)), json(result));
    let found = faults(&schema, &schema, &result, "");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_published_schemas_are_the_present_ones() {
    let all = sealegs::schema::all().unwrap();
    for schema in &all {
        let there = std::fs::read_to_string(published().join(schema.file)).unwrap_or_default();
        assert!(
            there == schema.text,
            "docs/schema/{} is out of date: run `sealegs schema -o docs/schema`",
            schema.file
        );
    }
    let names: BTreeSet<String> = std::fs::read_dir(published())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(names, all.iter().map(|schema| schema.file.to_owned()).collect());
}

#[test]
fn what_the_verbs_write_is_what_their_schemas_say() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let file = |name: &str| at(name).to_str().unwrap().to_owned();
    succeeds(&["mystery", "--seed", "4", "--duration", "3", "-o", &file("made")]);
    let one = file("made");
    succeeds(&["compare", &one, "--json", &file("compare.json")]);
    valid("compare.json", &at("compare.json"));
    succeeds(&["compare", &one, "--as-is", "--json", &file("as-is.json")]);
    valid("compare.json", &at("as-is.json"));
    succeeds(&["diagnose", &one, "--json", &file("diagnose.json")]);
    valid("diagnose.json", &at("diagnose.json"));
    succeeds(&["diagnose", &one, "--jobs", &file("jobs")]);
    succeeds(&["merge", &file("jobs"), "--json", &file("several.json")]);
    valid("diagnose-several.json", &at("several.json"));
    let add = ["add", "coulomb-friction", "--to", "thor-linear", "--campaign", &one];
    succeeds(&[&add[..], &["-o", &file("better.toml"), "--json", &file("add.json")]].concat());
    valid("add.json", &at("add.json"));
    let judge = ["mystery", "--seed", "4", "--duration", "3", "--judge", "--json", &file("mystery.json")];
    succeeds(&judge);
    valid("mystery.json", &at("mystery.json"));
    let drop = ["impact", "thor-impact", "--heights", "0.02", "--springs", "compliant"];
    succeeds(&[&drop[..], &["--set", "duration_s=0.2", "--json", &file("impact.json")]].concat());
    valid("impact.json", &at("impact.json"));

    // A result that is not what the schema says is seen.
    let schema = json(&published().join("diagnose.json"));
    let good = json(&at("diagnose.json"));
    for (pointer, wrong) in [
        ("/verdict", Value::from("perhaps")),
        ("/base/holdout_error", Value::Null),
        ("/base/parameters/0/unit", Value::from(1.0)),
        ("/effects", Value::from("backlash")),
        ("/work/simulations", Value::from(1.5)),
    ] {
        let mut bad = good.clone();
        *bad.pointer_mut(pointer).unwrap() = wrong;
        let found = faults(&schema, &schema, &bad, "");
        assert!(found.iter().any(|fault| fault.starts_with(&format!("{pointer}:"))), "{pointer}: {found:?}");
    }
    for key in ["campaign", "noise_floor", "base", "verdict", "effects", "indistinguishable", "after"] {
        let mut bad = good.clone();
        bad.as_object_mut().unwrap().remove(key);
        assert!(!faults(&schema, &schema, &bad, "").is_empty(), "{key} may be missing");
    }
}
