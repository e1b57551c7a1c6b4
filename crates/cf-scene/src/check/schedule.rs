//! `run`: an end, and a bounded number of frames.

use super::{Checker, out_of_range};
use crate::error::{Detail, number};
use crate::scene::Schedule;
use crate::spec::RunSpec;

/// The most frames of one run.
const MAX_FRAMES: u32 = 100_000;

/// Decides when to stop and when to write.
pub(super) fn schedule(check: &mut Checker<'_>, spec: &RunSpec) -> Schedule {
    check.not_negative("run.until", spec.until);
    check.require(spec.frames.is_none() || spec.every.is_none(), "run.every", || {
        Detail::new("frames and every both say when to write").advice("remove one, or set one to None")
    });
    check.require(spec.steps != Some(0), "run.steps", || Detail::new("out of range").expected("1 or more").found("0"));
    let nothing = Schedule { until: spec.until, frames: 1, interval: spec.until, steps: spec.steps };
    if let Some(every) = spec.every {
        let frames = (spec.until / every - 1e-9).ceil().max(1.0);
        let good = check.positive("run.every", every)
            && check.require(frames <= f64::from(MAX_FRAMES), "run.every", || {
                out_of_range(
                    &format!(
                        "at most {MAX_FRAMES} frames, so every at least {}",
                        number(spec.until / f64::from(MAX_FRAMES))
                    ),
                    every,
                )
            });
        return if good { Schedule { frames: frames as u32, interval: every, ..nothing } } else { nothing };
    }
    let frames = spec.frames.unwrap_or(1);
    let good = check.require((1..=MAX_FRAMES).contains(&frames), "run.frames", || {
        out_of_range(&format!("1 to {MAX_FRAMES}"), f64::from(frames))
    });
    if good { Schedule { frames, interval: spec.until / f64::from(frames), ..nothing } } else { nothing }
}
