//! Spread of ten pillars, at the frame rate and at a hundredth of its step; half an hour of one
//! core, less with several: `cargo run --release -p frangible-shots --example pillar_spread >
//! bench/results/pillar.csv`. An argument selects a single number of steps per second.

use frangible::Method;
use frangible_shots::ShotOptions;
use frangible_shots::claims::pillar_spread;
use rayon::prelude::*;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    println!("# cargo run --release -p frangible-shots --example pillar_spread");
    println!("method,steps_per_second,safeguards,seed,mean_m,p95_m,highest_m,rise_m");
    let cases = [
        ("frame-rate", Method::FrameRate, 30.0, "on"),
        ("paper", Method::Paper, 30.0, "on"),
        ("paper", Method::PaperUncorrected, 30.0, "off"),
        ("frame-rate", Method::FrameRate, 3000.0, "on"),
    ];
    let only: Option<f64> = std::env::args().nth(1).and_then(|argument| argument.parse().ok());
    for (name, method, frames_per_second, switch) in cases {
        if only.is_some_and(|only| only != frames_per_second) {
            continue;
        }
        let row = |seed: u64| {
            let options = ShotOptions { seed, method, frames_per_second, ..ShotOptions::default() };
            let spread = pillar_spread(&options).map_err(|obstacle| obstacle.to_string())?;
            Ok(format!(
                "{name},{frames_per_second},{switch},{seed},{:.4},{:.4},{:.4},{:.4}",
                spread.mean, spread.p95, spread.highest, spread.rise
            ))
        };
        let rows: Vec<Result<String, String>> = (0..10).into_par_iter().map(row).collect();
        for row in rows {
            println!("{}", row?);
        }
    }
    Ok(())
}
