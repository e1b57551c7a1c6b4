//! Every scene that comes with the program is sound at every preset, and says what the figures need.

use cf_scene::{Experiment, Limits, Model, SceneFile, Set, catalog};

fn open(name: &str) -> SceneFile {
    let scene = catalog::find(name).unwrap()[0];
    SceneFile::parse(&scene.file(), scene.text).unwrap_or_else(|problems| panic!("{problems}"))
}

fn unfold(name: &str, preset: Option<&str>) -> Experiment {
    open(name).experiment(preset, &[], &Limits { memory: 8 << 30 }).unwrap_or_else(|problems| panic!("{problems}"))
}

#[test]
fn every_scene_unfolds_at_every_preset() {
    for scene in catalog::SCENES {
        assert_eq!(open(scene.name).about().figure.as_deref(), Some(scene.figure));
        for preset in [None, Some("draft"), Some("standard"), Some("paper")] {
            let experiment = unfold(scene.name, preset);
            assert!(!experiment.runs.is_empty() && !experiment.claims.is_empty(), "{} {preset:?}", scene.name);
        }
    }
}

#[test]
fn figure_3_has_the_four_mach_numbers() {
    let experiment = unfold("3", Some("standard"));
    let ratio = |name: &str| match &experiment.run(name).unwrap().model {
        Model::Diffusion(model) => 0.5 / model.law.speed().unwrap(),
        Model::SingleField(_) => unreachable!(),
    };
    let expected = [("hc_1", 1.0), ("hc_2_over_root_3", 2.0 / 3f64.sqrt()), ("hc_root_2", 2f64.sqrt()), ("hc_2", 2.0)];
    for (name, hc) in expected {
        assert!((ratio(name) - hc).abs() < 1e-12, "{name}: {}", ratio(name));
    }
    assert_eq!(&experiment.runs[0].grid.cells[..], [256, 512]);
    assert_eq!(&unfold("3", Some("draft")).runs[0].grid.cells[..], [64, 128]);
    assert_eq!(experiment.claims.len(), 11);
    assert_eq!(unfold("3", Some("draft")).claims.len(), 3);
}

#[test]
fn the_source_of_figure_3_fills_whole_cells_at_every_preset() {
    for (preset, across) in [("draft", 2), ("standard", 8)] {
        let experiment = unfold("3", Some(preset));
        let (scene, grid) = (&experiment.runs[0], &experiment.runs[0].grid);
        let Model::Diffusion(model) = &scene.model else { unreachable!() };
        let inside = |i: usize, j: usize| {
            let point = [(i as f64 + 0.5) * grid.spacing, (j as f64 + 0.5) * grid.spacing];
            model.sources[0].shape.weight(&point, &grid.origin, &grid.extent) > 0.0
        };
        let count =
            (0..grid.cells[0]).flat_map(|i| (0..grid.cells[1]).map(move |j| (i, j))).filter(|(i, j)| inside(*i, *j));
        assert_eq!(count.count(), across * across);
    }
}

#[test]
fn figure_4_keeps_its_limit_runs_small_at_every_preset() {
    for preset in ["draft", "standard", "paper"] {
        let experiment = unfold("4", Some(preset));
        let limit = experiment.run("limit_4e-2").unwrap();
        assert_eq!((&limit.grid.cells[..], limit.schedule.until), (&[64, 128][..], 2.5));
        assert_eq!(limit.numerics, experiment.run("limit_fourier").unwrap().numerics);
    }
}

#[test]
fn flags_come_last_and_may_be_for_one_run() {
    let sets = [Set::parse("model.law.k=0.36").unwrap(), Set::parse("hc_2:model.law.k=0.04").unwrap()];
    let experiment = open("3").experiment(Some("draft"), &sets, &Limits::of_this_machine()).unwrap();
    let k = |name: &str| match &experiment.run(name).unwrap().model {
        Model::Diffusion(model) => model.law.k,
        Model::SingleField(_) => unreachable!(),
    };
    assert_eq!((k("hc_1"), k("hc_2")), (0.36, 0.04));
}

#[test]
fn memory_counts_only_what_a_run_needs() {
    let experiment = unfold("4", Some("standard"));
    let names = |run: &str| experiment.run(run).unwrap().memory().rows.iter().map(|row| row.name).collect::<Vec<_>>();
    assert!(names("ft_0").contains(&"q_C"));
    assert!(!names("ft_1").contains(&"q_C") && !names("fourier").contains(&"q_C"));
}
