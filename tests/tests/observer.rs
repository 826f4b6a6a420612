//! An observer of a model with nothing missing leaves what the sensors' noise makes, on motions as fast as a bench's chirp.

use sealegs::bench_model;
use sealegs_model::Model;
use sealegs_reference::campaign::{Order, Rig, SUBSTEPS};
use sealegs_sysid::data::Data;
use sealegs_sysid::diagnose::Models;
use sealegs_sysid::fit::{FitOptions, fit};
use sealegs_sysid::residual::by_channel;
use sealegs_sysid::{Campaign, Role};

/// Root mean square residuals by channel, noise units, of a campaign of an independent simulator with nothing hidden, fitted
/// under the observer.
fn left(rig: Rig) -> Vec<(String, f64)> {
    let order = Order {
        name: "clean".to_owned(),
        rig,
        seed: 4,
        hidden: Vec::new(),
        duration_s: 6.0,
        substeps: SUBSTEPS,
        rough: Vec::new(),
    };
    let made = order.make();
    let folder = tempfile::tempdir().unwrap();
    for (file, text) in made.files() {
        std::fs::write(folder.path().join(file), text).unwrap();
    }
    let mut campaign = Campaign::read(folder.path()).unwrap();
    let model = bench_model::of_campaign(&mut campaign, None, Vec::new()).unwrap();
    let data = Data::new(&campaign, Some(Role::Fit), &model).unwrap();
    let models = Models::new(&data, &model);
    let observed: &dyn Model = models.observed.as_deref().expect("the bench measures its motion");
    let fitted = fit(&data, observed, &FitOptions::default()).unwrap();
    by_channel(&data, &fitted.evaluation).into_iter().map(|e| (e.channel, e.error)).collect()
}

#[test]
fn reference_what_follows_a_pendulum_leaves_its_noise() {
    for (channel, error) in left(Rig::Pendulum) {
        // The motor's encoder tells 0.05 um, the joint's 3 um: what the coarse one adds to the pull shows in the fine one.
        let most = if channel == "motor_angle_rad" { 5.0 } else { 1.15 };
        assert!(error < most, "{channel}: {error} noise units");
    }
}

#[test]
fn reference_what_follows_a_locked_bench_leaves_its_noise() {
    for (channel, error) in left(Rig::Locked) {
        // The fine encoder shows what its own smoothing leaves of the chirp's end.
        let most = if channel == "motor_angle_rad" { 2.0 } else { 1.15 };
        assert!(error < most, "{channel}: {error} noise units");
    }
}
