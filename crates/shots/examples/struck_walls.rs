//! Remains of a brick wall after ten balls, at the frame rate and at a hundredth of its step; an
//! hour of one core, less with several: `cargo run --release -p frangible-shots --example
//! struck_walls > bench/results/walls.csv`. An argument selects a single number of steps per
//! second.

use frangible_shots::ShotOptions;
use frangible_shots::claims::struck_wall;
use rayon::prelude::*;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    println!("# cargo run --release -p frangible-shots --example struck_walls");
    println!("steps_per_second,seed,median_m,mean_m,standing");
    let only: Option<f64> = std::env::args().nth(1).and_then(|argument| argument.parse().ok());
    for frames_per_second in [30.0, 3000.0] {
        if only.is_some_and(|only| only != frames_per_second) {
            continue;
        }
        (0..10).into_par_iter().try_for_each(|seed: u64| {
            let options = ShotOptions { seed, frames_per_second, ..ShotOptions::default() };
            let wall = struck_wall(&options).map_err(|obstacle| obstacle.to_string())?;
            println!(
                "{frames_per_second},{seed},{:.4},{:.4},{:.4}",
                wall.median, wall.mean, wall.standing
            );
            Ok::<_, String>(())
        })?;
    }
    Ok(())
}
