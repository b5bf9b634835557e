//! What is to be said about the stipples and the curves of a scene.

use dotwork_drawing::Warnings;
use dotwork_ink::BakeMethod;
use dotwork_ink::bake::reference_scale;
use dotwork_ink::lines::Criteria;

use crate::scene::{Object, Scene};

/// By how much the scale of a view may differ from that of a bake of voxels or faces before it is said.
const OTHER_SCALE: f32 = 2.0;

impl Scene {
    /// What is to be said about the stipples of the baked objects in this view: `bake=voxel` where there is no volume
    /// for it, voxels or faces whose lists had to be shortened, and a scale of more than twice or less than half of that
    /// which they were baked for.
    pub fn bake_warnings(&self) -> Warnings {
        let mut warnings = Warnings::new();
        let scale = reference_scale(&self.view(), &self.page);
        for object in &self.objects {
            let (Some(stock), name) = (&object.stock, &object.name) else { continue };
            let cut = object.source.as_ref().is_some_and(|source| source.cut.is_some());
            if object.draws_curves() && !cut {
                curve_warnings(object, &mut warnings);
            }
            let Some(elements) = &stock.elements else {
                if object.style.bake == BakeMethod::Voxel && !cut {
                    warnings.say(format!(
                        "{name}: there are no voxels for bake=voxel; its dots lie on its surface"
                    ));
                }
                continue;
            };
            let faces = elements.are_faces();
            if !faces && object.style.bake != BakeMethod::Voxel {
                warnings
                    .say(format!("{name}: its stipples are those of voxels, from a file without the volume"));
            }
            if elements.n_max < elements.wanted {
                warnings.say(match faces {
                    true => format!(
                        "{name}: its faces show {:.0} % of the stipples that they were asked for; a smaller k_max asks for fewer",
                        100.0 * elements.n_max / elements.wanted
                    ),
                    false => format!(
                        "{name}: a voxel shows {} stipples instead of {:.0}; a smaller k_max asks for fewer",
                        elements.n_max, elements.wanted
                    ),
                });
            }
            if let Some(of_bake) = elements.reference {
                let times = scale / of_bake;
                if !(1.0 / OTHER_SCALE..=OTHER_SCALE).contains(&times) {
                    warnings.say(format!(
                        "{name}: its {} were baked for a picture of another scale (this one is {times:.2} times that)",
                        if faces { "faces" } else { "voxels" }
                    ));
                }
            }
        }
        warnings
    }
}

/// What is to be said about the curves of an object that is to draw some.
fn curve_warnings(Object { name, curves, style, .. }: &Object, warnings: &mut Warnings) {
    let Some(curves) = curves else {
        warnings.say(format!("{name}: there are no voxels for curves=true"));
        return;
    };
    if !curves.holds(&Criteria::of(style)) {
        warnings.say(format!(
            "{name}: its curves have t_log up to {} and t_grad from {}, from a file without the volume",
            curves.t_log, curves.t_grad
        ));
    }
    if curves.least > curves.t_grad && curves.least > style.t_grad {
        warnings.say(format!(
            "{name}: too many voxels for curves; t_grad counts as {:.3}, a larger one or a smaller t_log asks for fewer",
            curves.least
        ));
    }
}
