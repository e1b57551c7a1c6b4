//! The runs: a table of all, and everything about each.

use super::markup::{bytes, escape, link, number, seconds};
use crate::summary::{FlowSummary, RunSummary};
use std::fmt::Write;

/// Side by side, what compares.
pub(super) fn table(page: &mut String, runs: &[RunSummary]) {
    if runs.is_empty() {
        return;
    }
    page.push_str(
        "<section>\n<h2>Runs</h2>\n<div class=\"wide\"><table class=\"numbers\">\n<thead><tr><th>Run</th><th>Cells</th>\
         <th>Steps</th><th>Iterations</th><th>Projection</th><th>Time</th><th>Per step</th><th>Mass drift</th></tr></thead>\n<tbody>\n",
    );
    for run in runs {
        let iterations = if run.iterations.solves == 0 {
            "–".to_owned()
        } else {
            format!("{} (max {})", number(run.iterations.mean), run.iterations.max)
        };
        let projections = run.flow.as_ref().map_or("–".to_owned(), |flow| {
            format!("{} (max {})", number(flow.projections.mean), flow.projections.max)
        });
        let _ = writeln!(
            page,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{iterations}</td><td>{projections}</td><td>{}</td><td>{}</td><td>{:.1e}</td></tr>",
            escape(&run.label),
            cells(run),
            run.steps,
            seconds(run.seconds.total),
            seconds(run.seconds.per_step),
            run.mass.drift,
        );
    }
    page.push_str("</tbody>\n</table></div>\n</section>\n");
}

/// Everything about each run, folded away.
pub(super) fn details(page: &mut String, runs: &[RunSummary]) {
    if runs.is_empty() {
        return;
    }
    page.push_str("<section>\n<h2>Plans and details</h2>\n");
    for run in runs {
        let _ = writeln!(page, "<details><summary>{} <code>{}</code></summary>", escape(&run.label), escape(&run.name));
        plan(page, run);
        phases(page, run);
        numbers(page, run);
        if !run.files.is_empty() {
            let links: Vec<String> = run.files.iter().map(|file| link(file, file)).collect();
            let _ = writeln!(page, "<p class=\"files\">{}</p>", links.join(" "));
        }
        page.push_str("</details>\n");
    }
    page.push_str("</section>\n");
}

fn plan(page: &mut String, run: &RunSummary) {
    let regime = &run.regime;
    let mut law = escape(&regime.name);
    for (name, value, unit) in
        [("c", regime.speed, " m/s"), ("H_c", regime.hc, ""), ("half angle", regime.half_angle, "°")]
    {
        if let Some(value) = value {
            let _ = write!(law, ", {name} = {}{unit}", number(value));
        }
    }
    let dt = if run.dt[0] == run.dt[1] {
        number(run.dt[0])
    } else {
        format!("{} to {}", number(run.dt[0]), number(run.dt[1]))
    };
    let because = |words: &str| if words.is_empty() { String::new() } else { format!(": {}", escape(words)) };
    let rows = [
        ("regime", law),
        ("grid", format!("{} cells, h = {} m, {}", cells(run), number(run.spacing), escape(&run.precision))),
        ("threads", run.threads.to_string()),
        ("time step", format!("{dt} s{}", because(&run.dt_reason))),
        ("integrator", format!("{}{}", escape(&run.integrator), because(&run.integrator_reason))),
        ("transport", escape(&run.advection)),
        ("solver", format!("{}{}", escape(&run.solver), because(&run.solver_reason))),
        ("largest residual", format!("{:.1e}", run.residual)),
        ("error", escape(&run.error.sentence())),
        ("peak memory", bytes(run.peak_memory)),
    ];
    let mut rows = rows.to_vec();
    if let Some(flow) = &run.flow {
        rows.extend(fluid(flow));
    }
    if run.rejections > 0 {
        rows.push(("steps made again", run.rejections.to_string()));
    }
    if let Some(target) = &run.target {
        rows.push(("target", escape(&target.words)));
    }
    page.push_str("<dl class=\"plan\">\n");
    for (name, value) in rows {
        let _ = writeln!(page, "<dt>{name}</dt><dd>{value}</dd>");
    }
    page.push_str("</dl>\n");
}

/// What a solved fluid did.
fn fluid(flow: &FlowSummary) -> Vec<(&'static str, String)> {
    let p = &flow.projections;
    let mut rows = vec![
        ("flow", escape(&flow.scheme)),
        ("pressure", format!("{}: {}", escape(&flow.solver), escape(&flow.solver_reason))),
        ("projections", format!("{}, {} iterations each (at most {})", p.solves, number(p.mean), p.max)),
        ("max|div u| dt", format!("{:.1e} of {:.0e} allowed", flow.divergence, flow.eta_div)),
        ("largest |u|", format!("{} m/s, max|u| dt/h = {}", number(flow.speed), number(flow.courant))),
        ("kinetic energy", format!("{} at the end; work of forces {}", number(flow.energy), number(flow.work))),
    ];
    if let Some(hc) = flow.hc {
        let share = 100.0 * hc.above_one;
        let words =
            format!("mean {}, at most {}, above 1 in {share:.1} % of the cells", number(hc.mean), number(hc.max));
        rows.push(("H_c over the cells", words));
    }
    rows
}

fn phases(page: &mut String, run: &RunSummary) {
    let all: f64 = run.seconds.phases.values().sum();
    if all <= 0.0 {
        return;
    }
    page.push_str("<h3>Where the time went</h3>\n<dl class=\"bars\">\n");
    for (name, &s) in &run.seconds.phases {
        let share = (100.0 * s / all).clamp(0.0, 100.0);
        let _ = writeln!(
            page,
            "<dt>{}</dt><dd><span class=\"bar\" style=\"width:{share:.1}%\"></span><span>{} ({share:.0} %)</span></dd>",
            escape(name),
            seconds(s)
        );
    }
    page.push_str("</dl>\n");
}

fn numbers(page: &mut String, run: &RunSummary) {
    let mass = &run.mass;
    page.push_str("<h3>Budgets</h3>\n<table class=\"numbers\"><tbody>\n");
    let mut row = |name: &str, value: String| {
        let _ = writeln!(page, "<tr><th scope=\"row\">{name}</th><td>{value}</td></tr>");
    };
    for (name, value) in [
        ("mass at the start", mass.start),
        ("emitted", mass.emitted),
        ("left through the walls", mass.outflow),
        ("mass at the end", mass.end),
    ] {
        row(name, number(value));
    }
    row("drift, relative", format!("{:.1e}", mass.drift));
    for range in &run.ranges {
        row(&format!("range of {}", escape(&range.field)), format!("{} to {}", number(range.min), number(range.max)));
    }
    for field in &run.fields {
        row(&format!("memory: {}", escape(&field.name)), bytes(field.bytes));
    }
    page.push_str("</tbody></table>\n");
}

fn cells(run: &RunSummary) -> String {
    run.cells.iter().map(ToString::to_string).collect::<Vec<_>>().join(" × ")
}
