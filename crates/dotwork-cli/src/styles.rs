//! `dotwork styles`: the presets, and the reference of all style keys.

use dotwork::ink::{Kind, PARAMS, PRESETS, Param};
use dotwork::{Style, read_style};
use serde_json::{Value, json};

use crate::args::StylesArgs;
use crate::options::style_by_name;
use crate::report::{self, Failure};
use crate::words::{list, wrapped};

/// Columns of the reference.
const WIDTH: usize = 80;

/// Lists styles or keys.
pub fn run(args: &StylesArgs) -> Result<(), Failure> {
    let shown = match &args.name {
        Some(name) => Some((name.as_str(), summary(name)?, style_by_name(name)?)),
        None if args.keys => Some((PRESETS[0].name, PRESETS[0].summary.to_string(), Style::default())),
        None => None,
    };
    if args.json {
        let value = match &shown {
            Some((name, summary, style)) => json!({ "name": name, "summary": summary, "keys": keys(style) }),
            None => {
                let presets: Vec<Value> = PRESETS
                    .iter()
                    .map(|p| json!({ "name": p.name, "summary": p.summary, "values": values(&p.style()) }))
                    .collect();
                json!({ "styles": presets, "keys": keys(&Style::default()) })
            }
        };
        return report::print(&format!("{value:#}\n"));
    }
    match shown {
        None => {
            let rows: Vec<_> = PRESETS.iter().map(|p| (p.name, p.summary.to_string())).collect();
            let hint = "\ndotwork styles NAME shows every key of a style; a style file begins like this:\n\n  \
                        extends = \"soft\"\n  gamma = 1.7\n";
            report::print(&(list(&rows) + hint))
        }
        Some((name, summary, style)) => report::print(&reference(name, &summary, &style)),
    }
}

fn summary(name: &str) -> Result<String, Failure> {
    match PRESETS.iter().find(|p| p.name == name) {
        Some(preset) => Ok(preset.summary.to_string()),
        None => {
            style_by_name(name)?;
            Ok(read_style(name)?.description)
        }
    }
}

/// The reference of all keys, with their values in `style`.
fn reference(name: &str, summary: &str, style: &Style) -> String {
    let mut text = format!("{name}: {summary}\n");
    let mut group = "";
    for param in PARAMS {
        if param.group != group {
            group = param.group;
            text += &format!("\n{group}\n");
        }
        let (value, default) = (param.get(style), param.default());
        text += &format!("\n  {} = {value}", param.name);
        if value != default {
            text += &format!("    (default {default})");
        }
        text.push('\n');
        text += &wrapped(param.help, 6, WIDTH);
        let unit = if param.unit.is_empty() { String::new() } else { format!(", {}", param.unit) };
        text += &wrapped(&format!("{}{unit}", param.kind), 6, WIDTH);
        if !param.equation.is_empty() {
            text += &wrapped(&format!("[{}]", param.equation), 6, WIDTH);
        }
    }
    text
}

fn values(style: &Style) -> Value {
    PARAMS.iter().map(|p| (p.name.to_string(), typed(p, &p.get(style)))).collect()
}

fn keys(style: &Style) -> Value {
    PARAMS.iter().map(|p| key(p, style)).collect()
}

fn key(param: &Param, style: &Style) -> Value {
    let mut key = json!({
        "key": param.name,
        "group": param.group,
        "value": typed(param, &param.get(style)),
        "default": typed(param, &param.default()),
        "unit": param.unit,
        "help": param.help,
        "equation": param.equation,
    });
    match param.kind {
        Kind::Number { min, max } => {
            key["kind"] = json!("number");
            key["range"] = json!([exact(&min.to_string()), exact(&max.to_string())]);
        }
        Kind::Choice(words) => {
            key["kind"] = json!("choice");
            key["range"] = json!(words);
        }
        Kind::Switch => {
            key["kind"] = json!("switch");
            key["range"] = json!([false, true]);
        }
        Kind::Color | Kind::Length => {
            key["kind"] = json!(if param.kind == Kind::Color { "color" } else { "length" });
            key["range"] = json!(param.kind.to_string());
        }
        Kind::Text(form) => {
            key["kind"] = json!("text");
            key["range"] = json!(form);
        }
    }
    key
}

/// The value as JSON has it: numbers and switches as themselves, all else as text.
fn typed(param: &Param, text: &str) -> Value {
    match param.kind {
        Kind::Number { .. } => exact(text),
        Kind::Switch => json!(text == "true"),
        _ => json!(text),
    }
}

/// A number as it is written, not as `f32` widened.
fn exact(text: &str) -> Value {
    text.parse::<f64>().map_or_else(|_| json!(text), |v| json!(v))
}
