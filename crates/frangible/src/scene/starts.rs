//! Bodies that wait: checks of when they start.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::starts::{StartsDesc, StartsWhen};
use crate::scene::desc::{BodyDesc, Method, MotionDesc};
use crate::step::waiting::state::{Starts, Waiting};
use frangible_bodies::Velocity;

/// State of a body that waits, if it does; `velocity` is the one that it starts with.
pub(crate) fn build_waiting(
    desc: &BodyDesc,
    velocity: Velocity,
    is_anchored: bool,
    method: Method,
    at: &Checker,
) -> Result<Option<Waiting>, BuildError> {
    let Some(starts) = desc.starts else { return Ok(None) };
    match desc.motion {
        MotionDesc::Dynamic if is_anchored => {
            return Err(at.broken("on a body with anchors", "left out: the world holds it"));
        }
        MotionDesc::Dynamic => {}
        MotionDesc::Kinematic => {
            let rule = "left out: before its first key a path stands still";
            return Err(at.broken("on a kinematic body", rule));
        }
        MotionDesc::Static => {
            return Err(at.broken("on a static body", "left out, or the body dynamic"));
        }
    }
    let starts = match starts {
        StartsDesc { frame: Some(frame), when: None } => Starts::AtFrame(u64::from(frame)),
        StartsDesc { frame: None, when: Some(StartsWhen::Struck) } => Starts::WhenStruck,
        StartsDesc { frame: Some(_), when: Some(_) } => {
            return Err(at.broken("with both 'frame' and 'when'", "with one of the two"));
        }
        StartsDesc { frame: None, when: None } => {
            return Err(at.broken("with neither 'frame' nor 'when'", "with one of the two"));
        }
    };
    if starts == Starts::WhenStruck {
        if method.is_papers() {
            let rule = "a frame, with the paper's method, which seeks impacts while bodies move";
            return Err(at.field("when").broken("struck", rule));
        }
        if velocity != Velocity::default() {
            let rule = "left out on a body with an initial velocity, which starts at a frame";
            return Err(at.field("when").broken("struck", rule));
        }
    }
    Ok(Some(Waiting { starts, velocity }))
}
