//! The one table of style parameters: each is declared once, with its name, range, default, unit, help and source.
//!
//! From this table come the fields of [`Style`], `--set key=value`, the keys of style files, the list in the
//! command's help, and the checks of every value. A new parameter is one entry below.

use std::fmt;

use dotwork_drawing::{Color, Length, Unit};

/// What values a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number from `min` to `max`, both included.
    Number {
        /// Smallest value.
        min: f32,
        /// Largest value.
        max: f32,
    },
    /// `true` or `false`.
    Switch,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A colour, `#rrggbb`.
    Color,
    /// A length on the page: `1.5px`, `0.25mm`, or `0.2%` of the page's shorter side.
    Length,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::Number { min, max } => write!(f, "{min} to {max}"),
            Kind::Switch => f.write_str("true or false"),
            Kind::Choice(words) => f.write_str(&words.join(" | ")),
            Kind::Color => f.write_str("#rrggbb"),
            Kind::Length => f.write_str("px, mm or % of the page"),
        }
    }
}

/// One row of the parameter table.
#[derive(Clone, Copy, Debug)]
pub struct Param {
    /// The key, as in `--set key=value`.
    pub name: &'static str,
    /// The heading it stands under.
    pub group: &'static str,
    /// What values it takes.
    pub kind: Kind,
    /// Unit of the value; empty for plain numbers.
    pub unit: &'static str,
    /// What it does, in one sentence.
    pub help: &'static str,
    /// The term of the tone or of the drawing rule that it enters, and its source; empty if there is none.
    pub equation: &'static str,
    get: fn(&Style) -> String,
    set: fn(&mut Style, &str, &Param) -> Result<(), String>,
}

impl Param {
    /// The parameter's value in `style`, as text that [`Style::set`] reads back.
    pub fn get(&self, style: &Style) -> String {
        (self.get)(style)
    }

    /// The default value as text.
    pub fn default(&self) -> String {
        self.get(&Style::default())
    }
}

/// A value that a parameter can hold.
trait Value: Sized {
    fn parse(s: &str, param: &Param) -> Result<Self, String>;
    fn show(&self) -> String;
}

impl Value for f32 {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        let Kind::Number { min, max } = param.kind else {
            unreachable!("{} is declared as a number", param.name)
        };
        match s.trim().parse::<f32>() {
            Ok(v) if v >= min && v <= max => Ok(v),
            _ => Err(format!("{} takes a number from {min} to {max}, not '{s}'", param.name)),
        }
    }

    fn show(&self) -> String {
        self.to_string()
    }
}

impl Value for bool {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        match s.trim() {
            "true" => Ok(true),
            "false" => Ok(false),
            _ => Err(format!("{} takes true or false, not '{s}'", param.name)),
        }
    }

    fn show(&self) -> String {
        self.to_string()
    }
}

impl Value for Color {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        s.trim().parse().map_err(|e| format!("{}: {e}", param.name))
    }

    fn show(&self) -> String {
        self.to_string()
    }
}

impl Value for Length {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        let length: Length = s.parse().map_err(|e| format!("{}: {e}", param.name))?;
        if length.value > 0.0 {
            Ok(length)
        } else {
            Err(format!("{} must be more than 0, not '{s}'", param.name))
        }
    }

    fn show(&self) -> String {
        self.to_string()
    }
}

/// Declares an enum whose variants are the words of a [`Kind::Choice`].
macro_rules! choice {
    ($(#[$meta:meta])* $name:ident { $($(#[$vmeta:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name { $($(#[$vmeta])* $variant),+ }

        impl $name {
            const WORDS: &'static [&'static str] = &[$($word),+];
        }

        impl Value for $name {
            fn parse(s: &str, param: &Param) -> Result<Self, String> {
                match s.trim() {
                    $($word => Ok($name::$variant),)+
                    _ => Err(format!("{} takes {}, not '{s}'", param.name, Self::WORDS.join(" or "))),
                }
            }

            fn show(&self) -> String {
                match self { $($name::$variant => $word.to_string()),+ }
            }
        }
    };
}

choice! {
    /// Which side of the form gets the ink.
    Inked {
        /// The side away from the light: black ink on white paper.
        Shade = "shade",
        /// The lit side: white ink on black paper.
        Light = "light",
    }
}

choice! {
    /// How a dot near its threshold arrives.
    Fade {
        /// It grows.
        Size = "size",
        /// It strengthens, at full size.
        Ink = "ink",
        /// It simply appears.
        Off = "off",
    }
}

choice! {
    /// What hides a dot.
    Visibility {
        /// Nothing: every layer prints, as in the papers' volumes.
        Through = "through",
        /// Facing away from the eye.
        Facing = "facing",
        /// Facing away, or lying behind the surface.
        Solid = "solid",
    }
}

choice! {
    /// Whether back faces are drawn.
    TwoSided {
        /// On open surfaces only.
        Auto = "auto",
        /// Always.
        Yes = "true",
        /// Never.
        No = "false",
    }
}

macro_rules! style {
    ($($group:literal { $($name:ident: $type:ty = $default:expr, $kind:expr, $unit:literal, $help:literal, $equation:literal;)+ })+) => {
        /// A drawing style: every parameter of the table, as a field.
        ///
        /// The default is the preset `soft`.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Style {
            $($(#[doc = $help] #[doc = ""] #[doc = concat!("Unit: ", $unit, ". ", $equation)] pub $name: $type,)+)+
        }

        impl Default for Style {
            fn default() -> Self {
                Style { $($($name: $default,)+)+ }
            }
        }

        /// All parameters, in the order of the documentation.
        pub const PARAMS: &[Param] = &[$($(Param {
            name: stringify!($name),
            group: $group,
            kind: $kind,
            unit: $unit,
            help: $help,
            equation: $equation,
            get: |style| Value::show(&style.$name),
            set: |style, s, param| {
                style.$name = <$type as Value>::parse(s, param)?;
                Ok(())
            },
        },)+)+];
    };
}

const UNIT: Kind = Kind::Number { min: 0.0, max: 1.0 };

style! {
    "Tone" {
        tone: f32 = 1.0, UNIT, "ink", "Factor on the whole tone; in style flat, the uniform tone itself.",
            "ink = tone * (base + light * shade^gamma + silhouette * (1 - |n.E|)^silhouette_power)";
        base: f32 = 0.02, UNIT, "ink", "Ink that lies on every part of the form.", "the sum's first term";
        light: f32 = 1.0, UNIT, "ink", "Ink of the parts that turn away from the light.",
            "the sum's second term; shade = 1 - max(0, (n.L + wrap) / (1 + wrap))";
        inked: Inked = Inked::Shade, Kind::Choice(Inked::WORDS), "",
            "Which side gets the ink: shade (dark ink on light paper) or light (light ink on dark paper).",
            "light inks 1 - shade instead of shade";
        wrap: f32 = 0.3, UNIT, "", "Lets the light reach round the form: 0 stops at the terminator, 1 at the far side.",
            "Lambert with wrap";
        gamma: f32 = 1.7, Kind::Number { min: 0.1, max: 8.0 }, "",
            "Shape of the shading: above 1 opens the half-tones, below 1 darkens them.", "exponent of shade";
        silhouette: f32 = 0.3, UNIT, "ink", "Ink where the surface turns away from the eye.", "the sum's third term";
        silhouette_power: f32 = 5.0, Kind::Number { min: 0.5, max: 32.0 }, "",
            "How close to the outline the silhouette's ink stays: larger is closer.", "exponent of 1 - |n.E|";
        distance: f32 = 0.0, Kind::Number { min: -1.0, max: 1.0 }, "",
            "Lightens what is far (positive) or near (negative).",
            "ink * (1 - distance * z), z = 0 at the near and 1 at the far end of the bounding sphere";
        resolution: f32 = 1.0, UNIT, "",
            "1 keeps the ink per page area under perspective; 0 keeps it per area of the surface, so that far parts darken.",
            "ink * (depth / depth of the centre)^(2 (1 - resolution)); after Lu et al. 2003, T_r";
        highlight: f32 = 0.0, Kind::Number { min: 0.0, max: 0.9 }, "ink",
            "Tones lighter than this stay bare paper; the others are stretched to meet it.",
            "max(0, ink - highlight) / (1 - highlight)";
        shadow: f32 = 0.95, UNIT, "ink", "Darkest tone that dots are asked for.", "upper clamp of ink";
        solid: bool = false, Kind::Switch, "", "Lets tones reach full black: the shadow clamp is lifted and dots merge.",
            "upper clamp 1";
        back: f32 = 0.15, UNIT, "ink", "Additional ink on back faces of open surfaces.", "ink + back where n.E < 0";
    }
    "Dots" {
        dot_size: Length = Length::percent(0.24), Kind::Length, "diameter", "Diameter of a dot that faces the eye.",
            "r = dot_size / 2";
        foreshorten: f32 = 0.5, UNIT, "",
            "How dots shrink where the surface turns away: 0 keeps their size, 0.5 draws fine edges. Spacing compensates.",
            "r * |n.E|^foreshorten";
        fade: Fade = Fade::Size, Kind::Choice(Fade::WORDS), "",
            "How a dot near its threshold arrives: it grows, strengthens or simply appears.",
            "arrival = min(1, (radius - spacing) / (fade_width * spacing))";
        fade_width: f32 = 0.15, Kind::Number { min: 0.01, max: 1.0 }, "of the spacing",
            "Over which share of the spacing a dot arrives.", "see fade";
        min_size: f32 = 0.05, Kind::Number { min: 0.0, max: 0.9 }, "of the full size",
            "Smallest share of its size (or strength) at which an arriving dot is drawn.", "arrival < min_size draws nothing";
        grow: f32 = 0.6, Kind::Number { min: 0.0, max: 3.0 }, "ink area",
            "In the darks, dots grow instead of multiplying once their summed area passes this share of the page area; 0 never.",
            "r * sqrt(x / grow) for x > grow, x the ink area per page area";
        regularity: f32 = 1.0, UNIT, "", "1 spaces the dots as evenly as possible; 0 is looser, like a hand.",
            "a stipple's radius is its distance times 1 - 0.6 (1 - regularity) h";
    }
    "Lines" {
        outlines: bool = true, Kind::Switch, "", "Draws the outline: a line where the surface turns away from the eye.",
            "the contour n.E = 0 of the smooth surface, without what is hidden";
        outline: Length = Length::percent(0.2), Kind::Length, "width", "Width of the outline at the depth of the centre.",
            "width * depth of the centre / depth";
        outline_min: Length = Length::percent(1.5), Kind::Length, "length",
            "Visible stretches of outline shorter than this are left out.", "";
    }
    "Colour" {
        color: Color = Color::BLACK, Kind::Color, "sRGB", "Colour of the ink.", "";
        paper: Color = Color::WHITE, Kind::Color, "sRGB", "Colour of the paper.", "";
    }
    "Surface" {
        visibility: Visibility = Visibility::Solid, Kind::Choice(Visibility::WORDS), "",
            "What hides a dot: nothing (through), facing away (facing), or also what lies before it (solid).", "";
        front_angle: f32 = 90.0, Kind::Number { min: 1.0, max: 90.0 }, "degrees",
            "With facing or solid: largest angle between the normal and the eye at which dots are drawn.", "Lu et al. 2003";
        two_sided: TwoSided = TwoSided::Auto, Kind::Choice(TwoSided::WORDS), "",
            "Whether back faces are drawn: auto draws them on open surfaces.", "";
        crease_angle: f32 = 180.0, Kind::Number { min: 0.0, max: 180.0 }, "degrees",
            "Edges whose faces meet at more than this angle shade as creases; 180 keeps every normal smooth.", "";
    }
}

impl Style {
    /// Makes every dot as large as a pen of this diameter draws it.
    pub fn use_pen(&mut self, pen: Length) {
        (self.dot_size, self.fade, self.foreshorten, self.grow) = (pen, Fade::Off, 0.0, 0.0);
    }

    /// The diameter in millimetres of the pen with which this style draws, if it draws every dot with one: a size in
    /// millimetres that neither arrival nor foreshortening nor dark tones change.
    pub fn pen_mm(&self) -> Option<f32> {
        let fixed = self.fade == Fade::Off && self.foreshorten == 0.0 && self.grow == 0.0;
        (fixed && self.dot_size.unit == Unit::Mm).then_some(self.dot_size.value)
    }

    /// Sets one parameter from text.
    ///
    /// # Errors
    /// Names the parameter and what it takes; for an unknown name, the nearest known ones.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        let param = find_param(name)?;
        (param.set)(self, value, param)
    }

    /// Reads `key=value`.
    ///
    /// # Errors
    /// As [`Style::set`], and when there is no `=`.
    pub fn set_pair(&mut self, pair: &str) -> Result<(), String> {
        let (name, value) =
            pair.split_once('=').ok_or_else(|| format!("'{pair}' is not key=value, for example tone=0.3"))?;
        self.set(name.trim(), value)
    }
}

/// The row of the table with this name.
///
/// # Errors
/// For an unknown name, suggests the nearest known ones.
pub fn find_param(name: &str) -> Result<&'static Param, String> {
    if let Some(param) = PARAMS.iter().find(|p| p.name == name) {
        return Ok(param);
    }
    let mut near: Vec<(usize, &str)> = PARAMS.iter().map(|p| (edit_distance(name, p.name), p.name)).collect();
    near.sort();
    let close = near[0].0 <= 3 || near[0].1.contains(name);
    Err(if close {
        format!("there is no style key '{name}'; did you mean '{}'?", near[0].1)
    } else {
        let all: Vec<&str> = PARAMS.iter().map(|p| p.name).collect();
        format!("there is no style key '{name}'; the keys are {}", all.join(", "))
    })
}

/// Levenshtein's distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, cb) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_reads_back_what_it_shows() {
        let style = Style::default();
        for p in PARAMS {
            let mut copy = style.clone();
            copy.set(p.name, &p.get(&style)).unwrap();
            assert_eq!(copy, style, "{}", p.name);
            assert!(!p.help.is_empty() && p.help.ends_with('.'), "{} has a sentence of help", p.name);
        }
    }

    #[test]
    fn a_pen_draws_every_dot_with_its_size() {
        assert_eq!(Style::default().pen_mm(), None);
        let mut style = Style { fade: Fade::Ink, foreshorten: 0.5, grow: 0.9, ..Style::default() };
        style.use_pen(Length::mm(0.25));
        assert_eq!(style.pen_mm(), Some(0.25));
        for (key, value) in [("fade", "size"), ("foreshorten", "0.1"), ("grow", "0.5"), ("dot_size", "2px")] {
            let mut other = style.clone();
            other.set(key, value).unwrap();
            assert_eq!(other.pen_mm(), None, "{key} = {value}");
        }
    }

    #[test]
    fn values_outside_are_refused_by_name() {
        let mut style = Style::default();
        for (key, bad) in [
            ("tone", "1.5"),
            ("tone", "-0.1"),
            ("tone", "nan"),
            ("tone", ""),
            ("solid", "yes"),
            ("fade", "slow"),
            ("color", "blueish"),
            ("dot_size", "0px"),
            ("dot_size", "inf"),
        ] {
            let error = style.set(key, bad).unwrap_err();
            assert!(error.contains(key), "{key}={bad}: {error}");
        }
        assert_eq!(style, Style::default());
    }

    #[test]
    fn unknown_keys_suggest_the_nearest() {
        let mut style = Style::default();
        assert!(style.set("dotsize", "1px").unwrap_err().contains("dot_size"));
        assert!(style.set("zzzzzzzzzzzz", "1").unwrap_err().contains("silhouette_power"));
        assert!(style.set_pair("tone").unwrap_err().contains("key=value"));
    }
}
