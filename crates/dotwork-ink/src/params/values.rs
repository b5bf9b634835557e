//! The types that parameters have, each read from and shown as text.

use std::fmt;

use dotwork_drawing::{Color, ColorSpace, Length, Palette};

use super::{Kind, Param};
use crate::coloring::PALETTES;

/// Numbers that also take `true` for 1 and `false` for 0: among the papers' factors they are switches.
const SWITCHES: [&str; 3] = ["silhouette", "resolution", "distance"];

/// A value that a parameter can hold.
pub(super) trait Value: Sized {
    fn parse(s: &str, param: &Param) -> Result<Self, String>;
    fn show(&self) -> String;
}

impl Value for f32 {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        let Kind::Number { min, max } = param.kind else {
            unreachable!("{} is declared as a number", param.name)
        };
        let word = match s.trim() {
            "true" => Some(1.0),
            "false" => Some(0.0),
            _ => None,
        };
        match word.filter(|_| SWITCHES.contains(&param.name)).ok_or(()).or_else(|()| s.trim().parse::<f32>())
        {
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

impl Value for ColorSpace {
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
            pub(super) const WORDS: &'static [&'static str] = &[$($word),+];
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
    /// How outlines are drawn.
    LineMethod {
        /// As strokes: contours of the smooth surface, without what is hidden.
        Vector = "vector",
        /// As a picture: the edges of back faces that are as near as the front faces there.
        Image = "image",
    }
}

choice! {
    /// What is drawn for a voxel of a silhouette curve.
    CurvesMethod {
        /// A segment through its centre, along the curve.
        Segment = "segment",
        /// Lines to those of its neighbours that belong to a silhouette too.
        Search = "search",
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
    /// Where a feature of a volume has its surface.
    SurfaceChoice {
        /// Where the volume has one value.
        Iso = "iso",
        /// Where the gradient is longest, near there.
        Ridge = "ridge",
    }
}

choice! {
    /// What an object is in its picture.
    Role {
        /// One among others.
        Plain = "plain",
        /// What the picture is about.
        Focus = "focus",
        /// What the focus lies in: it hides nothing but itself and its like, and is thinned before the focus.
        Context = "context",
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

choice! {
    /// How the tone of a place follows from its terms.
    Factors {
        /// Ink is a sum of terms.
        Sum = "sum",
        /// The count of dots is a product of the papers' factors.
        Papers = "papers",
    }
}

choice! {
    /// Where the exponent of the papers' silhouette factor stands.
    SilhouetteForm {
        /// `(1 − |n·E|)^k_se`.
        Outside = "outside",
        /// `1 − |n·E|^k_se`.
        Inside = "inside",
    }
}

choice! {
    /// What becomes of the fraction of a dot that an element asks for.
    Fraction {
        /// It is rounded.
        Off = "off",
        /// It is the strength of the element's last dot.
        Ink = "ink",
        /// It is the probability of that dot, where the element is small on the page.
        Probability = "probability",
    }
}

choice! {
    /// Who makes the order of the stipples.
    BakeMethod {
        /// One even order over the whole surface.
        BlueNoise = "blue-noise",
        /// A list for each voxel of a volume.
        Voxel = "voxel",
        /// A list for each face of a mesh.
        Face = "face",
        /// The vertices of the mesh and of its refinement, as edges collapse and split.
        Hierarchy = "hierarchy",
    }
}

choice! {
    /// Which faces show a dot first where each asks for less than one.
    Rank {
        /// Those that are evenly spread.
        Even = "even",
        /// Any.
        Random = "random",
    }
}

choice! {
    /// What is compared with the spacing that a place asks for.
    Relevance {
        /// A stipple's radius: one number, made by the bake.
        Radius = "radius",
        /// The edges to its relevant neighbours as they are projected: all must be longer.
        Edges = "edges",
    }
}

choice! {
    /// What the colours of dots follow.
    Coloring {
        /// Nothing: all have one colour.
        None = "none",
        /// The light.
        Light = "light",
        /// The distance from the eye.
        Depth = "depth",
        /// The light, and the distance.
        Both = "both",
        /// The surface's own colours.
        Own = "own",
    }
}

/// The colours along light or depth, where `warm` and `cool` do not say them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum PaletteChoice {
    /// From `cool` to `warm`.
    #[default]
    None,
    /// One of [`PALETTES`], by its name there.
    Named(&'static str),
    /// These colours.
    List(Palette),
}

impl Value for PaletteChoice {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        let s = s.trim();
        if s == "none" {
            return Ok(PaletteChoice::None);
        }
        if let Some((name, _)) = PALETTES.iter().find(|(name, _)| *name == s) {
            return Ok(PaletteChoice::Named(name));
        }
        if !s.contains(',') {
            return refused(s, param);
        }
        // One more than there may be is enough to say no.
        let colors: Result<Vec<Color>, String> =
            s.split(',').take(Palette::MOST + 1).map(|c| c.trim().parse()).collect();
        let palette = colors.and_then(|colors| match colors.len() {
            n if n > Palette::MOST => Err(format!("has more than {} colours", Palette::MOST)),
            _ => Palette::new(colors),
        });
        palette.map(PaletteChoice::List).map_err(|e| format!("{}: {e}", param.name))
    }

    fn show(&self) -> String {
        match self {
            PaletteChoice::None => "none".into(),
            PaletteChoice::Named(name) => name.to_string(),
            PaletteChoice::List(palette) => palette.to_string(),
        }
    }
}

/// Colour of the lines; `None` where they have that of the ink.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutlineColor(pub Option<Color>);

impl Value for OutlineColor {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        match s.trim() {
            "auto" => Ok(OutlineColor(None)),
            s => Color::parse(s, param).map(|color| OutlineColor(Some(color))),
        }
    }

    fn show(&self) -> String {
        self.0.map_or("auto".into(), |color| color.to_string())
    }
}

/// What fills the surface under the dots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fill {
    /// Nothing: the paper shows.
    #[default]
    None,
    /// The surface's own colours.
    Own,
    /// One colour.
    Color(Color),
}

impl Value for Fill {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        match s.trim() {
            "none" => Ok(Fill::None),
            "own" => Ok(Fill::Own),
            s => s.parse().map(Fill::Color).or_else(|_: String| refused(s, param)),
        }
    }

    fn show(&self) -> String {
        match self {
            Fill::None => "none".into(),
            Fill::Own => "own".into(),
            Fill::Color(color) => color.to_string(),
        }
    }
}

/// Diameter of the dots of the strongest gradient; `None` where all dots have the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SizeMax(pub Option<Length>);

impl Value for SizeMax {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        if s.trim() == "off" {
            return Ok(SizeMax(None));
        }
        match s.parse::<Length>() {
            Ok(length) if length.value > 0.0 => Ok(SizeMax(Some(length))),
            _ => refused(s, param),
        }
    }

    fn show(&self) -> String {
        self.0.map_or("off".into(), |length| length.to_string())
    }
}

/// How strong a gradient must be to carry stipples, over the strongest; `None` where it follows from the data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GradientMin(pub Option<f32>);

impl Value for GradientMin {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        match (s.trim(), s.trim().parse::<f32>()) {
            ("auto", _) => Ok(GradientMin(None)),
            (_, Ok(share)) if (0.0..=1.0).contains(&share) => Ok(GradientMin(Some(share))),
            _ => refused(s, param),
        }
    }

    fn show(&self) -> String {
        self.0.map_or("auto".into(), |share| share.to_string())
    }
}

/// Which feature of a volume is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FeatureChoice {
    /// The one that most of the boundaries belong to, the lowest first.
    #[default]
    Auto,
    /// The one with the lowest values.
    Outer,
    /// The one with the highest values.
    Dense,
    /// This one of those that were found, counted from 1.
    Number(u32),
    /// What has values in this range.
    Range([f64; 2]),
}

impl fmt::Display for FeatureChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FeatureChoice::Auto => f.write_str("auto"),
            FeatureChoice::Outer => f.write_str("outer"),
            FeatureChoice::Dense => f.write_str("dense"),
            FeatureChoice::Number(n) => write!(f, "{n}"),
            FeatureChoice::Range([lo, hi]) => write!(f, "{lo},{hi}"),
        }
    }
}

/// A range of values; `None` where it follows from the data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Window(pub Option<[f64; 2]>);

/// How many connected parts are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Keep {
    /// All but specks.
    #[default]
    Auto,
    /// All.
    All,
    /// This many, the largest first.
    Largest(u32),
}

/// A part of a volume's box: from and to along each axis, in shares 0…1; `None` is the whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crop(pub Option<[[f64; 2]; 3]>);

/// What is cut away.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Clip {
    /// Single slices are cut open between their two sides, so that their values are seen; nothing else is.
    #[default]
    Auto,
    /// Conditions on shares of the object's box, joined by `;`; empty for nothing. What they mean is worked out where
    /// the object is known.
    Planes(String),
}

impl Clip {
    /// The conditions; empty for nothing, and where they depend on the object.
    pub fn planes(&self) -> &str {
        match self {
            Clip::Auto => "",
            Clip::Planes(planes) => planes,
        }
    }
}

/// `N` finite numbers between commas.
fn numbers<const N: usize>(s: &str) -> Option<[f64; N]> {
    let mut parts = s.split(',').map(|part| part.trim().parse::<f64>().ok().filter(|v| v.is_finite()));
    let mut out = [0.0; N];
    for v in &mut out {
        *v = parts.next()??;
    }
    parts.next().is_none().then_some(out)
}

fn refused<T>(s: &str, param: &Param) -> Result<T, String> {
    Err(format!("{} takes {}, not '{s}'", param.name, param.kind))
}

impl Value for FeatureChoice {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        let s = s.trim();
        Ok(match s {
            "auto" => FeatureChoice::Auto,
            "outer" => FeatureChoice::Outer,
            "dense" => FeatureChoice::Dense,
            _ => match (s.parse::<u32>(), numbers(s)) {
                (Ok(n), _) if n > 0 => FeatureChoice::Number(n),
                (_, Some([lo, hi])) if lo < hi => FeatureChoice::Range([lo, hi]),
                _ => return refused(s, param),
            },
        })
    }

    fn show(&self) -> String {
        self.to_string()
    }
}

impl Value for Window {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        match (s.trim(), numbers(s)) {
            ("auto", _) => Ok(Window(None)),
            (_, Some([lo, hi])) if lo < hi => Ok(Window(Some([lo, hi]))),
            _ => refused(s, param),
        }
    }

    fn show(&self) -> String {
        self.0.map_or("auto".into(), |[lo, hi]| format!("{lo},{hi}"))
    }
}

impl Value for Keep {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        match (s.trim(), s.trim().parse::<u32>()) {
            ("auto", _) => Ok(Keep::Auto),
            ("all", _) => Ok(Keep::All),
            (_, Ok(n)) if n > 0 => Ok(Keep::Largest(n)),
            _ => refused(s, param),
        }
    }

    fn show(&self) -> String {
        match self {
            Keep::Auto => "auto".into(),
            Keep::All => "all".into(),
            Keep::Largest(n) => n.to_string(),
        }
    }
}

impl Value for Clip {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        match s.trim() {
            "auto" => Ok(Clip::Auto),
            "none" => Ok(Clip::Planes(String::new())),
            s if !s.is_empty() && s.len() < 1000 && !s.contains(char::is_control) => {
                Ok(Clip::Planes(s.into()))
            }
            s => refused(s, param),
        }
    }

    fn show(&self) -> String {
        match self {
            Clip::Auto => "auto".into(),
            Clip::Planes(planes) if planes.is_empty() => "none".into(),
            Clip::Planes(planes) => planes.clone(),
        }
    }
}

impl Value for Crop {
    fn parse(s: &str, param: &Param) -> Result<Self, String> {
        if s.trim() == "none" {
            return Ok(Crop(None));
        }
        match numbers::<6>(s).map(|[a, b, c, d, e, f]| [[a, b], [c, d], [e, f]]) {
            Some(part) if part.iter().all(|[lo, hi]| 0.0 <= *lo && lo < hi && *hi <= 1.0) => {
                Ok(Crop(Some(part)))
            }
            _ => refused(s, param),
        }
    }

    fn show(&self) -> String {
        match self.0 {
            None => "none".into(),
            Some(part) => part.as_flattened().iter().map(f64::to_string).collect::<Vec<_>>().join(","),
        }
    }
}
