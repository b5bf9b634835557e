//! From what headers say of steps and origin to an affine that holds.

use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, Space, Unit};
use glam::{DMat3, DVec3};

/// The names of axes in messages.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Three unit steps closer to one plane than this (the volume of their parallelepiped) are no grid.
const FLATTEST: f64 = 1e-6;

/// From a point or step in RAS (+x right, +y anterior, +z superior) to LPS (+x left, +y posterior, +z superior).
pub(crate) fn lps_from_ras(v: DVec3) -> DVec3 {
    // Adding 0 turns −0 into 0.
    DVec3::new(-v.x, -v.y, v.z) + DVec3::ZERO
}

/// A spacing that can be used: the declared one, or 1 with a warning if that is 0 or no number.
pub(crate) fn usable_spacing(declared: f64, axis: usize, warnings: &mut Warnings) -> f64 {
    if declared.is_finite() && declared.abs() > 1e-100 && declared.abs() < 1e100 {
        return declared;
    }
    warnings.say(format!("the spacing along {} is {declared}: 1 assumed", AXES[axis]));
    1.0
}

/// An affine of steps (`None`: the file does not give this one) and an origin. Missing steps are completed at right
/// angles, one unit long; steps that make no grid are replaced by their lengths along the axes, with a warning.
pub(crate) fn affine(
    steps: [Option<DVec3>; 3],
    origin: DVec3,
    space: Space,
    unit: Unit,
    warnings: &mut Warnings,
) -> Affine {
    let usable = |step: DVec3| step.is_finite() && step.length() > 1e-100 && step.length() < 1e100;
    let mut good = true;
    let mut columns = steps;
    for (axis, column) in columns.iter_mut().enumerate() {
        if let Some(step) = *column
            && !usable(step)
        {
            warnings.say(format!("the step along {} is {step}: 1 assumed", AXES[axis]));
            *column = None;
            good = false;
        }
    }
    let completed = complete(columns);
    let lengths = DVec3::from_array(completed.map(DVec3::length));
    let units = completed.map(DVec3::normalize_or_zero);
    let flat = units[0].cross(units[1]).dot(units[2]).abs() < FLATTEST;
    if flat {
        warnings.say("the steps along x, y and z lie in a plane: taken along the axes of the world");
    }
    let linear = if flat {
        DMat3::from_diagonal(lengths)
    } else {
        DMat3::from_cols(completed[0], completed[1], completed[2])
    };
    let origin = if origin.is_finite() {
        origin
    } else {
        warnings.say("the origin is not finite: 0 assumed");
        DVec3::ZERO
    };
    let space = if good && !flat { space } else { Space::Unknown };
    Affine { linear, origin, space, unit }
}

fn complete(steps: [Option<DVec3>; 3]) -> [DVec3; 3] {
    let unit = |v: DVec3| v.normalize_or_zero();
    match steps {
        [Some(x), Some(y), Some(z)] => [x, y, z],
        [Some(x), Some(y), None] => [x, y, or_axis(unit(x.cross(y)), 2)],
        [Some(x), None, Some(z)] => [x, or_axis(unit(z.cross(x)), 1), z],
        [None, Some(y), Some(z)] => [or_axis(unit(y.cross(z)), 0), y, z],
        [Some(x), None, None] => {
            // The world's own axes where they fit.
            let y = if x.normalize().y.abs() < 0.9 { DVec3::Y } else { DVec3::Z };
            let z = unit(x.cross(y));
            [x, unit(z.cross(x)), z]
        }
        [None, Some(y), None] => {
            let [y, z, x] = complete([Some(y), None, None]);
            [x, y, z]
        }
        [None, None, Some(z)] => {
            let [z, x, y] = complete([Some(z), None, None]);
            [x, y, z]
        }
        [None, None, None] => [DVec3::X, DVec3::Y, DVec3::Z],
    }
}

fn or_axis(v: DVec3, axis: usize) -> DVec3 {
    if v == DVec3::ZERO { DVec3::AXES[axis] } else { v }
}

/// The unit that a file calls `name`, and how many of it make one of the file's.
pub(crate) fn unit_named(name: &str) -> Option<(Unit, f64)> {
    let name = name.trim().trim_matches('"').to_lowercase();
    let singular = name.strip_suffix('s').filter(|n| n.len() > 3).unwrap_or(&name);
    Some(match singular {
        "mm" | "millimeter" | "millimetre" => (Unit::Millimetre, 1.0),
        "cm" | "centimeter" | "centimetre" => (Unit::Millimetre, 10.0),
        // The micro sign, the Greek letter, and how ImageJ and XML escape the sign.
        "um" | "µm" | "μm" | "\\u00b5m" | "&#181;m" | "&#xb5;m" | "micron" | "micrometer" | "micrometre" => {
            (Unit::Micrometre, 1.0)
        }
        "nm" | "nanometer" | "nanometre" => (Unit::Nanometre, 1.0),
        "å" | "angstrom" => (Unit::Nanometre, 0.1),
        "m" | "meter" | "metre" => (Unit::Metre, 1.0),
        "inch" | "in" => (Unit::Millimetre, 25.4),
        _ => return None,
    })
}

/// How many of `unit` make one of `named`, a unit and how many of it that is; `None` if nobody can know.
pub(crate) fn converted(named: (Unit, f64), unit: Unit) -> Option<f64> {
    let (of, factor) = named;
    if of == unit {
        return Some(factor);
    }
    Some(factor * of.millimetres()? / unit.millimetres()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_many_names() {
        for (names, expected) in [
            ("mm MM millimeters millimetre \"mm\"", (Unit::Millimetre, 1.0)),
            ("cm centimetres", (Unit::Millimetre, 10.0)),
            ("um µm μm \\u00B5m &#181;m &#xB5;m micron microns micrometers", (Unit::Micrometre, 1.0)),
            ("nm nanometres", (Unit::Nanometre, 1.0)),
            ("Å angstrom Angstroms", (Unit::Nanometre, 0.1)),
            ("m meters metre", (Unit::Metre, 1.0)),
            ("in inch", (Unit::Millimetre, 25.4)),
        ] {
            for name in names.split(' ') {
                assert_eq!(unit_named(name), Some(expected), "{name}");
            }
        }
        for name in ["", "s", "ms", "pixel", "pixels", "mms"] {
            assert_eq!(unit_named(name), None, "{name}");
        }
        assert_eq!(converted((Unit::Millimetre, 10.0), Unit::Micrometre), Some(10_000.0));
        assert_eq!(converted((Unit::Unknown, 1.0), Unit::Unknown), Some(1.0));
        assert_eq!(converted((Unit::Unknown, 1.0), Unit::Metre), None);
    }

    #[test]
    fn missing_steps_are_completed_at_right_angles() {
        let mut warnings = Warnings::new();
        for known in 0..8u32 {
            let given = [DVec3::new(2.0, 1.0, 0.0), DVec3::new(-1.0, 2.0, 0.5), DVec3::new(0.0, 0.5, 3.0)];
            let steps = [0, 1, 2].map(|i| (known >> i & 1 == 1).then_some(given[i]));
            let affine = affine(steps, DVec3::ZERO, Space::Patient, Unit::Unknown, &mut warnings);
            assert!(affine.linear.determinant() > 0.1, "{known}: {affine:?}");
            for (i, column) in
                [affine.linear.x_axis, affine.linear.y_axis, affine.linear.z_axis].iter().enumerate()
            {
                match steps[i] {
                    Some(step) => assert_eq!(*column, step),
                    None => assert!((column.length() - 1.0).abs() < 1e-12),
                }
            }
        }
        assert!(warnings.is_empty());
    }

    #[test]
    fn what_makes_no_grid_is_replaced_and_said() {
        let bad = [
            [DVec3::X, DVec3::X * 2.0, DVec3::Z * 3.0],
            [DVec3::X, DVec3::ZERO, DVec3::Z],
            [DVec3::X, DVec3::NAN, DVec3::Z],
            [DVec3::X, DVec3::Y, DVec3::Z * 1e300],
        ];
        for steps in bad {
            let mut warnings = Warnings::new();
            let affine = affine(steps.map(Some), DVec3::NAN, Space::Patient, Unit::Unknown, &mut warnings);
            assert_eq!(affine.space, Space::Unknown, "{steps:?}");
            assert!(affine.linear.determinant() > 0.1 && affine.linear.is_finite(), "{affine:?}");
            assert_eq!(affine.origin, DVec3::ZERO);
            assert_eq!(warnings.iter().count(), 2);
        }
    }
}
