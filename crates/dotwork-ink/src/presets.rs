//! The presets: styles with a name and a one-line reason.

use dotwork_drawing::{Color, Length};

use crate::params::{BakeMethod, Clip, Factors, Fade, FeatureChoice, Inked, SizeMax, Style, Visibility};

/// A named style.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Name, as in `--style NAME`.
    pub name: &'static str,
    /// What it is for, in one line.
    pub summary: &'static str,
    make: fn() -> Style,
}

impl Preset {
    /// The style.
    pub fn style(&self) -> Style {
        (self.make)()
    }
}

/// All presets, the default first.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "soft",
        summary: "Even shading from a soft light: the scientific plate. The default.",
        make: Style::default,
    },
    Preset { name: "hard", summary: "Strong light and deep shadow: relief, texture, stone.", make: hard },
    Preset {
        name: "high-key",
        summary: "Mostly bare paper, fine dots: delicate forms and labels drawn over them.",
        make: high_key,
    },
    Preset { name: "night", summary: "White dots on black, with a lit rim.", make: night },
    Preset {
        name: "engraving",
        summary: "Very fine dots and full tones: close to a mezzotint.",
        make: engraving,
    },
    Preset { name: "sepia", summary: "Warm brown ink on cream paper, a looser hand.", make: sepia },
    Preset {
        name: "bone",
        summary: "The densest feature of a volume in a hard light: skulls, skeletons.",
        make: bone,
    },
    Preset { name: "skin", summary: "A soft surface without hard shadows: faces, soft tissue.", make: skin },
    Preset {
        name: "ghost",
        summary: "A translucent body: its form, and faintly what lies within.",
        make: ghost,
    },
    Preset {
        name: "xray",
        summary: "Every surface that turns away from the eye, through everything before it.",
        make: xray,
    },
    Preset {
        name: "brain-cutaway",
        summary: "A quarter cut away, its values on the cut: an MR brain reads only so.",
        make: brain_cutaway,
    },
    Preset {
        name: "industrial",
        summary: "Even tones and firm outlines: cast and machined parts.",
        make: industrial,
    },
    Preset {
        name: "microscopy",
        summary: "Noise smoothed away, specks dropped, fine dots: confocal stacks and the like.",
        make: microscopy,
    },
    Preset {
        name: "outline",
        summary: "Lines alone: outlines, borders and sharp edges; --set dots=true adds the dots.",
        make: outline,
    },
    Preset {
        name: "flat",
        summary: "For measuring: one uniform tone (--set tone=0.3), every other factor off.",
        make: flat,
    },
    Preset {
        name: "lambert",
        summary: "For measuring: tone * (1 - max(0, n.L)) and nothing else.",
        make: lambert,
    },
    Preset {
        name: "papers",
        summary: "Lu et al. 2002 and 2003: lists of dots in voxels, thinned by a product of factors; nothing hides.",
        make: papers,
    },
];

/// The style of a preset.
pub fn preset(name: &str) -> Option<Style> {
    PRESETS.iter().find(|p| p.name == name).map(Preset::style)
}

fn hard() -> Style {
    Style {
        base: 0.0,
        wrap: 0.0,
        gamma: 2.0,
        silhouette: 0.2,
        silhouette_power: 8.0,
        highlight: 0.05,
        shadow: 0.98,
        dot_size: Length::percent(0.26),
        ..Style::default()
    }
}

fn high_key() -> Style {
    Style {
        base: 0.0,
        light: 0.7,
        wrap: 0.35,
        gamma: 1.8,
        silhouette: 0.45,
        silhouette_power: 4.0,
        highlight: 0.015,
        dot_size: Length::percent(0.18),
        ..Style::default()
    }
}

fn night() -> Style {
    Style {
        inked: Inked::Light,
        base: 0.01,
        light: 0.9,
        wrap: 0.1,
        gamma: 1.6,
        silhouette: 0.5,
        silhouette_power: 4.0,
        color: Color::WHITE,
        paper: Color { r: 0x0b, g: 0x0c, b: 0x10 },
        ..Style::default()
    }
}

fn engraving() -> Style {
    Style { base: 0.05, gamma: 1.3, dot_size: Length::percent(0.15), ..Style::default() }
}

fn sepia() -> Style {
    Style {
        regularity: 0.3,
        dot_size: Length::percent(0.28),
        color: Color { r: 0x4a, g: 0x2c, b: 0x17 },
        paper: Color { r: 0xf7, g: 0xf0, b: 0xe1 },
        ..Style::default()
    }
}

fn bone() -> Style {
    Style {
        feature: FeatureChoice::Dense,
        base: 0.0,
        wrap: 0.15,
        gamma: 1.8,
        shadow: 0.97,
        ..Style::default()
    }
}

fn skin() -> Style {
    Style { smooth: 0.8, wrap: 0.45, gamma: 1.5, dot_size: Length::percent(0.2), ..Style::default() }
}

fn ghost() -> Style {
    Style {
        occlusion: 0.12,
        base: 0.0,
        light: 0.5,
        silhouette: 0.5,
        silhouette_power: 3.0,
        ..Style::default()
    }
}

fn xray() -> Style {
    Style {
        occlusion: 0.05,
        base: 0.0,
        light: 0.0,
        silhouette: 1.0,
        silhouette_power: 2.0,
        outlines: false,
        dot_size: Length::percent(0.18),
        ..Style::default()
    }
}

fn brain_cutaway() -> Style {
    Style { clip: Clip("x>0.5;z>0.55".into()), dot_size: Length::percent(0.2), ..Style::default() }
}

fn industrial() -> Style {
    Style {
        base: 0.03,
        wrap: 0.1,
        gamma: 1.4,
        silhouette: 0.15,
        outline: Length::percent(0.26),
        creases: true,
        ..Style::default()
    }
}

fn microscopy() -> Style {
    Style { smooth: 1.5, dot_size: Length::percent(0.18), silhouette: 0.4, ..Style::default() }
}

fn outline() -> Style {
    Style { dots: false, creases: true, ..Style::default() }
}

fn flat() -> Style {
    Style {
        tone: 0.5,
        base: 1.0,
        light: 0.0,
        silhouette: 0.0,
        back: 0.0,
        outlines: false,
        ..Style::default()
    }
}

fn lambert() -> Style {
    Style {
        tone: 0.8,
        base: 0.0,
        light: 1.0,
        wrap: 0.0,
        gamma: 1.0,
        silhouette: 0.0,
        back: 0.0,
        outlines: false,
        ..Style::default()
    }
}

/// The papers print values for few of their factors; these give 10 to 20 % of ink on the phantoms.
fn papers() -> Style {
    Style {
        factors: Factors::Papers,
        bake: BakeMethod::Voxel,
        k_max: 0.2,
        boundary: true,
        k_gc: 0.4,
        k_gs: 1.4,
        silhouette: 1.0,
        k_sc: 0.35,
        k_ss: 2.0,
        k_se: 2.0,
        resolution: 1.0,
        lighting: true,
        distance: 1.0,
        interior: false,
        front_angle: 90.0,
        visibility: Visibility::Through,
        size_max: SizeMax(Some(Length::percent(0.3))),
        foreshorten: 0.0,
        fade: Fade::Ink,
        grow: 0.0,
        back: 0.0,
        outlines: false,
        ..Style::default()
    }
}
