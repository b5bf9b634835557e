//! The one table of style parameters: each is declared once, with its name, range, default, unit, help and source.
//!
//! From this table come the fields of [`Style`], `--set key=value`, the keys of style files, the list in the
//! command's help, and the checks of every value. A new parameter is one entry below.

mod values;

use std::fmt;

use dotwork_drawing::{Color, ColorSpace, Length, Unit};

use values::Value;
pub use values::{
    BakeMethod, Clip, Coloring, Crop, CurvesMethod, Factors, Fade, FeatureChoice, Fill, Fraction,
    GradientMin, Inked, Keep, LineMethod, OutlineColor, PaletteChoice, Rank, Relevance, Role, SilhouetteForm,
    SizeMax, SurfaceChoice, TwoSided, Visibility, Window,
};

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
    /// A text of this form.
    Text(&'static str),
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::Number { min, max } => write!(f, "{min} to {max}"),
            Kind::Switch => f.write_str("true or false"),
            Kind::Choice(words) => f.write_str(&words.join(" | ")),
            Kind::Color => f.write_str("#rrggbb"),
            Kind::Length => f.write_str("px, mm or % of the page"),
            Kind::Text(form) => f.write_str(form),
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

/// The strengths and exponents of the papers' factors.
const STRENGTH: Kind = Kind::Number { min: 0.0, max: 20.0 };
const EXPONENT: Kind = Kind::Number { min: 0.0, max: 64.0 };

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
        silhouette: f32 = 0.3, UNIT, "ink", "Ink where the surface turns away from the eye; among the papers' factors all but 0 (or true) is on.",
            "the sum's third term";
        silhouette_power: f32 = 5.0, Kind::Number { min: 0.5, max: 32.0 }, "",
            "How close to the outline the silhouette's ink stays: larger is closer.", "exponent of 1 - |n.E|";
        distance: f32 = 0.0, Kind::Number { min: -1.0, max: 1.0 }, "",
            "Lightens what is far (positive) or near (negative); among the papers' factors all but 0 (or true) is on.",
            "ink * (1 - distance * z), z = 0 at the near and 1 at the far end of the bounding sphere";
        resolution: f32 = 1.0, UNIT, "",
            "1 keeps the ink per page area under perspective; 0 keeps it per area of the surface, so that far parts darken; \
             among the papers' factors all but 0 (or true) is on.",
            "ink * (depth / depth of the centre)^(2 (1 - resolution)); after Lu et al. 2003, T_r";
        highlight: f32 = 0.0, Kind::Number { min: 0.0, max: 0.9 }, "ink",
            "Tones lighter than this stay bare paper; the others are stretched to meet it.",
            "max(0, ink - highlight) / (1 - highlight)";
        shadow: f32 = 0.95, UNIT, "ink", "Darkest tone that dots are asked for.", "upper clamp of ink";
        solid: bool = false, Kind::Switch, "", "Lets tones reach full black: the shadow clamp is lifted and dots merge.",
            "upper clamp 1";
        texture: f32 = 0.0, UNIT, "",
            "How far the surface's own colours, where it has any, make the tone instead of the light.",
            "ink + texture * (tone * (1 - luminance) - ink)";
        back: f32 = 0.15, UNIT, "ink", "Additional ink on back faces of open surfaces.", "ink + back where n.E < 0";
        toon: f32 = 0.0, UNIT, "cosine",
            "Makes a silhouette of dots: places whose cosine between normal and eye is smaller are black; 0 makes none.",
            "ink + (1 - ink) * min(1, (1.1 toon - |n.E|) / (0.1 toon)); Lu et al. 2003, 5.6";
    }
    "Dots" {
        dots: bool = true, Kind::Switch, "", "Draws dots; false leaves the lines alone.", "";
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
        outline_thin: f32 = 0.0, UNIT, "",
            "How lines change their width with the size of the object on the page: 0 keeps it, 1 makes it proportional.",
            "width * (radius of the bounding sphere on the page / the radius that fits the page)^outline_thin; \
             Lu et al. 2003, 5.6";
        lines: LineMethod = LineMethod::Vector, Kind::Choice(LineMethod::WORDS), "",
            "Draws a mesh's outline as strokes, or as a picture: front faces into a depth buffer, and the edges of back faces \
             that are as near, all of one width.",
            "image: Raskar and Cohen 1999, in Lu et al. 2003, 5.6";
        creases: bool = false, Kind::Switch, "", "Draws sharp edges too, with the outline.",
            "edges whose faces meet at more than crease_min";
        crease_min: f32 = 50.0, Kind::Number { min: 10.0, max: 180.0 }, "degrees",
            "Edges of a mesh whose faces meet at more than this angle are sharp: outlines run along them.", "";
    }
    "Colour" {
        color: Color = Color::BLACK, Kind::Color, "sRGB", "Colour of the ink.", "";
        paper: Color = Color::WHITE, Kind::Color, "sRGB", "Colour of the paper.", "";
        outline_color: OutlineColor = OutlineColor(None), Kind::Text("auto | #rrggbb"), "sRGB",
            "Colour of the lines; auto gives them that of the ink. White ones part coloured forms.", "Lu et al. 2003, 5.7";
        coloring: Coloring = Coloring::None, Kind::Choice(Coloring::WORDS), "",
            "What the colours of dots follow, instead of color: the light (warm where it falls, cool in the shade), the \
             depth (warm near, cool far), both (the light's colours fade towards far), or the surface's own colours, where it \
             has any.",
            "light: u = (1 + n.L) / 2; depth: u = 1 - z, z = 0 at the near and 1 at the far end of the bounding sphere; \
             color = mix(cool, warm, u); both: mix(mix(cool, warm, (1 + n.L) / 2), far, z); after Lu et al. 2003, 5.7; own: the \
             nearest of color_steps colours that the surface's were cut into, at the median; after Heckbert 1982";
        warm: Color = crate::coloring::WARM, Kind::Color, "sRGB", "Colour of what is lit or near, u = 1.", "see coloring";
        cool: Color = crate::coloring::COOL, Kind::Color, "sRGB", "Colour of what is in the shade or far, u = 0.",
            "see coloring";
        far: Color = crate::coloring::FAR, Kind::Color, "sRGB",
            "With both: the colour towards which all others fade with distance.", "see coloring";
        color_space: ColorSpace = ColorSpace::Oklch, Kind::Choice(ColorSpace::WORDS), "",
            "Where colours are mixed: hls is the paper's hue, lightness and saturation; oklch is even to the eye.",
            "along the shorter way round the hue; hls: Lu et al. 2003, 5.7; oklch: Ottosson 2020";
        palette: PaletteChoice = PaletteChoice::None,
            Kind::Text("none | blue-orange | aerial | sunset | ocean | earth | viridis | #rrggbb,#rrggbb,... | FILE"), "",
            "Colours from u = 0 to u = 1 that take the place of cool and warm: one with a name, a list of 2 to 64, or a \
             file with one #rrggbb a line or a GIMP palette, which is read into a list.",
            "color = the two entries next to u, mixed";
        color_steps: f32 = 64.0, Kind::Number { min: 2.0, max: 64.0 }, "colours",
            "How many colours a form is drawn in at most; each is a layer, and for a plotter a pen.",
            "u, and with both u and z, in equal steps";
        fill: Fill = Fill::None, Kind::Text("none | own | #rrggbb"), "sRGB",
            "Fills the visible surface under all dots and lines: with one colour, or with the surface's own, where it has \
             any; own is color, or light grey where that is black, where it has none.", "";
        fill_opacity: f32 = 1.0, UNIT, "", "How far the fill covers the paper.", "";
        fill_shade: f32 = 0.0, UNIT, "", "Shades the fill by the light: 0 leaves it flat, 1 darkens it to black where none falls.",
            "linear light * (1 - fill_shade * shade), shade as in light; Lambert with wrap";
    }
    "Volume" {
        feature: FeatureChoice = FeatureChoice::Auto, Kind::Text("auto | outer | dense | N | LO,HI"), "",
            "Which feature of a volume is drawn: the one that auto takes for the form, the outermost, the densest, \
             number N of those that dotwork info lists, or what has values from LO to HI.",
            "the isosurface of the feature; see dotwork_volume::Features";
        surface: SurfaceChoice = SurfaceChoice::Iso, Kind::Choice(SurfaceChoice::WORDS), "",
            "Where a feature has its surface: at one value (iso), or where the values change fastest near there (ridge), \
             which follows a boundary whose values vary.",
            "ridge: up to 1.5 voxels along the normal to the largest |G|; after Canny 1986";
        window: Window = Window(None), Kind::Text("auto | LO,HI"), "value",
            "Values below LO count as LO and above HI as HI; auto leaves out the lowest and highest 0.1 % but for the air.",
            "v = (value - LO) / (HI - LO)";
        smooth: f32 = 0.5, Kind::Number { min: 0.0, max: 8.0 }, "of the largest voxel spacing",
            "Standard deviation of the Gaussian that smooths a volume before its surface is found; noise asks for 1 or 2.", "";
        cap: bool = true, Kind::Switch, "", "Closes the surface where the volume's box cuts it.", "";
        keep: Keep = Keep::Auto, Kind::Text("auto | all | N"), "components",
            "How many connected parts of the feature are kept, the largest first; auto drops specks.", "";
        crop: Crop = Crop(None), Kind::Text("none | X0,X1,Y0,Y1,Z0,Z1"), "of the volume's box",
            "The part of the volume that is looked at, in shares 0 to 1 of its sides.", "";
        clip: Clip = Clip::Auto, Kind::Text("auto | none | AXIS<SHARE or AXIS>SHARE, joined by ;"),
            "of the object's box",
            "Cuts away what satisfies all of these, as in x>0.5;z>0.6: an object is opened, and a volume shows its values \
             on the cut. auto cuts a volume of up to three slices along its middle, and nothing else.",
            "on a cut, ink = 0.02 + 0.72 u^1.2, u the mean of two: 1 for the lowest and 0 for the highest 2 % of the \
             values; and the share of the cut with higher values";
    }
    "Papers" {
        factors: Factors = Factors::Sum, Kind::Choice(Factors::WORDS), "",
            "How tone is made: as a sum of ink, or as a count of dots, the product of the papers' factors below.",
            "count = N_max * tone * T_b * T_s * T_r * T_l * T_d * T_i, cut to N_max; Lu et al. 2002, eq 2 and 3";
        bake: BakeMethod = BakeMethod::BlueNoise, Kind::Choice(BakeMethod::WORDS), "",
            "Who makes the order of the stipples: one even order over the surface, a list for each voxel of a volume or for \
             each face of a mesh, or the vertices of a mesh as its edges collapse and split. With the papers' factors voxel \
             means the faces where there is no volume.",
            "voxel: Lu et al. 2002, section 4.3; face: Lu et al. 2003, section 4; hierarchy: Meruvia Pastor et al. 2003, \
             section IV";
        rank: Rank = Rank::Even, Kind::Choice(Rank::WORDS), "",
            "Which faces show a dot first where each asks for less than one: even spreads them, random leaves it to chance.",
            "the number u of a face; random: Lu et al. 2003, 5.2";
        randomize: f32 = 1.0, UNIT, "",
            "How far a hierarchy moves its vertices at random, so that the rows of a mesh do not show: 0 leaves them.",
            "Meruvia Pastor et al. 2003, section IV-E";
        relevance: Relevance = Relevance::Radius, Kind::Choice(Relevance::WORDS), "",
            "What draws a stipple of a hierarchy: its radius, or all edges to its relevant neighbours as they are on the page.",
            "radius: radius >= spacing; edges: the shortest edge >= spacing; Meruvia Pastor et al. 2003, sections V-B and V-A";
        boundary: bool = true, Kind::Switch, "", "Draws more where values are high and gradients strong.",
            "T_b = v * (k_gc + k_gs * |G|^k_ge); Lu et al. 2002, eq 5";
        k_gc: f32 = 0.39, STRENGTH, "", "How much the value itself counts for the boundary factor.", "see boundary";
        k_gs: f32 = 0.51, STRENGTH, "", "Largest share of the gradient in the boundary factor.", "see boundary";
        k_ge: f32 = 1.0, EXPONENT, "", "Sharpness of the boundary: larger leaves only the strongest gradients.", "see boundary";
        k_sc: f32 = 0.279, STRENGTH, "", "How much the value itself counts for the silhouette factor.",
            "T_s = v * (k_sc + k_ss * (1 - |n.E|)^k_se); Lu et al. 2002, eq 6; on by silhouette";
        k_ss: f32 = 0.45, STRENGTH, "", "Largest share of the silhouette in its factor.", "see k_sc";
        k_se: f32 = 1.11, EXPONENT, "", "Sharpness of the silhouette.", "see k_sc";
        silhouette_form: SilhouetteForm = SilhouetteForm::Outside, Kind::Choice(SilhouetteForm::WORDS), "",
            "Where the exponent k_se stands, which the papers print in two ways: outside or inside the difference.",
            "outside: (1 - |n.E|)^k_se; inside: 1 - |n.E|^k_se";
        k_re: f32 = 2.0, EXPONENT, "", "How fast dots become fewer as they move away; 2 keeps their number per page area.",
            "T_r = (scale on the page / scale in the view of the bake)^k_re * |n.E|^k_nz; Lu et al. 2002, eq 7; on by resolution";
        k_nz: f32 = 0.0, EXPONENT, "", "How fast dots become fewer as their place turns away from the eye.", "see k_re";
        lighting: bool = true, Kind::Switch, "",
            "Draws fewer dots where light falls, and none beyond front_angle; what faces away from the light keeps all.",
            "T_l = 1 - max(0, n.L)^k_le; Lu et al. 2002, eq 10";
        k_le: f32 = 1.0, EXPONENT, "", "How closely the bright parts gather around the light's direction.", "see lighting";
        k_de: f32 = 1.0, Kind::Number { min: -20.0, max: 20.0 }, "",
            "How fast dots become fewer with depth: above 0 far ones, below 0 near ones.",
            "T_d = ((1 + z / a) / 2)^k_de, z in -a to a, towards the eye above 0; \
             ((1 - z / a) / 2)^-k_de below 0; Lu et al. 2002, eq 8; on by distance";
        interior: bool = false, Kind::Switch, "", "Draws fewer dots where gradients are weak, so that one looks into the volume.",
            "T_i = |G|^k_ie; Lu et al. 2002, eq 9";
        k_ie: f32 = 1.0, EXPONENT, "", "How fast weak gradients become transparent.", "see interior";
        size_max: SizeMax = SizeMax(None), Kind::Text("off | px, mm or % of the page"), "diameter",
            "Diameter of a dot of the strongest gradient, from which the others follow; off draws all with dot_size.",
            "size = |G| * size_max * T_r * T_d * T_i; Lu et al. 2002, eq 4";
        k_max: f32 = 0.2, Kind::Number { min: 0.01, max: 4.0 }, "",
            "Most stipples of a voxel or a face, over the pixels that it covers in the view of the bake, of which a page has \
             a thousand.",
            "N_max = k_max * rendered area / (X * Y * Z)^(2/3); Lu et al. 2002, eq 1; of a face k_max * its area";
        gradient_min: GradientMin = GradientMin(None), Kind::Text("auto | SHARE"), "of the strongest gradient",
            "Gradients that are weaker carry no stipples; auto finds the boundaries from the gradients' histogram.",
            "Lu et al. 2002, section 4.3";
        slab: f32 = 0.5, Kind::Number { min: 0.0, max: 4.0 }, "voxels",
            "Distance of the two planes between which a voxel's stipples lie.", "Lu et al. 2002, section 4.3";
        fraction: Fraction = Fraction::Probability, Kind::Choice(Fraction::WORDS), "",
            "What becomes of fractions of a dot: they are rounded (off), drawn as weaker dots (ink), or, where voxels or \
             faces are small on the page or faces ask for few dots, taken as probabilities.",
            "probability: count + w * (u - 1/2), u random for each voxel, w = 1 - min(1, area / min_area_px), for faces at \
             least min(1, 2 - count / 16); Lu et al. 2003, 5.2";
        min_area_px: f32 = 5.0, Kind::Number { min: 2.0, max: 9.0 }, "px^2",
            "Area on the page below which a voxel or a face counts as small.", "see fraction";
        curves: bool = false, Kind::Switch, "",
            "Draws the silhouette curves of a volume from its voxels, in the place of its outlines.",
            "voxels with |LoG| <= t_log, |n.E| < t_eye and |G| > t_grad; Lu et al. 2002, section 5.6; with factors=papers";
        curves_method: CurvesMethod = CurvesMethod::Segment, Kind::Choice(CurvesMethod::WORDS), "",
            "What is drawn for such a voxel: a segment along the curve, or lines to those of its neighbours that are such \
             voxels too.",
            "segment: through the centre along G x E, as long as a voxel; search: centre to centre in 3 x 3 x 3";
        t_log: f32 = 0.0, UNIT, "of the largest |LoG|",
            "How far from an edge in the volume curves may lie; 0 takes the voxels nearest to it, more makes curves thicker.",
            "LoG: the Laplacian of the volume smoothed by a Gaussian, 0 at edges; see curves";
        t_eye: f32 = 0.1, UNIT, "cosine",
            "How far from the outline curves may lie: the largest cosine between normal and eye.", "see curves";
        t_grad: f32 = 0.2, UNIT, "of the strongest gradient", "Weaker gradients carry no curves.", "see curves";
    }
    "Surface" {
        visibility: Visibility = Visibility::Solid, Kind::Choice(Visibility::WORDS), "",
            "What hides a dot: nothing (through), facing away (facing), or also what lies before it (solid).", "";
        occlusion: f32 = 1.0, UNIT, "",
            "With solid: how much a closed form hides what lies within and behind it: 1 all, 0 nothing, 0.2 makes a ghost.",
            "ink * exp(-k d), d the matter before the place in radii of the scene, k = 8 occlusion / (1 - occlusion)";
        role: Role = Role::Plain, Kind::Choice(Role::WORDS), "",
            "What the object is among others: a context hides only itself and other contexts, and is thinned where a focus \
             lies behind it.", "";
        context_thin: f32 = 0.75, UNIT, "", "Share of its ink that a context loses where a focus lies behind it.",
            "ink * (1 - context_thin)";
        front_angle: f32 = 90.0, Kind::Number { min: 1.0, max: 90.0 }, "degrees",
            "With facing, solid or the papers' lighting: largest angle between the normal and the eye at which dots are drawn.",
            "Lu et al. 2003";
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
        self.size_max = SizeMax(None);
        if self.fraction == Fraction::Ink {
            self.fraction = Fraction::Probability;
        }
    }

    /// The diameter in millimetres of the pen with which this style draws, if it draws every dot with one: a size in
    /// millimetres that neither arrival nor foreshortening nor dark tones change.
    pub fn pen_mm(&self) -> Option<f32> {
        let papers = self.factors == Factors::Papers;
        let varied = papers && (self.size_max.0.is_some() || self.fraction == Fraction::Ink);
        let fixed = self.fade == Fade::Off && self.foreshorten == 0.0 && self.grow == 0.0 && !varied;
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
    fn a_pen_draws_papers_with_one_size_too() {
        let mut style = crate::preset("papers").unwrap();
        style.fraction = Fraction::Ink;
        style.use_pen(Length::mm(0.25));
        assert_eq!(style.pen_mm(), Some(0.25));
        for (key, value) in [("size_max", "0.5mm"), ("fraction", "ink")] {
            let mut other = style.clone();
            other.set(key, value).unwrap();
            assert_eq!(other.pen_mm(), None, "{key}");
            other.factors = Factors::Sum;
            assert_eq!(other.pen_mm(), Some(0.25), "{key} acts on the papers' factors only");
        }
    }

    #[test]
    fn the_papers_switches_are_words_or_numbers() {
        let mut style = Style::default();
        for key in ["silhouette", "resolution", "distance"] {
            style.set(key, "true").unwrap();
            assert_eq!(find_param(key).unwrap().get(&style), "1");
            style.set(key, "false").unwrap();
            assert_eq!(find_param(key).unwrap().get(&style), "0");
        }
        assert!(style.set("gamma", "true").unwrap_err().contains("gamma"), "other numbers are numbers");
        style.set("size_max", "0.4%").unwrap();
        assert_eq!(style.size_max, SizeMax(Some(Length::percent(0.4))));
        for (key, bad) in [
            ("size_max", "0px"),
            ("min_area_px", "1"),
            ("min_area_px", "10"),
            ("slab", "-1"),
            ("bake", "white"),
        ] {
            assert!(style.set(key, bad).unwrap_err().contains(key), "{key}={bad}");
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
