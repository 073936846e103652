//! The things that the programs beside this one share: the file of a pile that they read, and the times and
//! states that they write.
//!
//! `python/frangible/bench/pile_file.py` writes the file and says what stands in it.

use cpu_time::ProcessTime;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write as _};

const MAGIC: &[u8] = b"FRANPILE";

/// In the frame of its body, whose origin is in the middle of a box or a ball.
pub enum Shape {
    /// The hull of vertices [m].
    Hull(Vec<[f64; 3]>),
    /// Along the axes: half of its edge lengths [m].
    Box([f64; 3]),
    /// Its radius [m].
    Ball(f64),
}

/// A convex body. Its frame has its origin in the centre of mass, and the principal axes of
/// inertia.
pub struct Body {
    pub shape: Shape,
    /// Of the centre of mass, world frame [m].
    pub position: [f64; 3],
    /// `world_from_body`, x, y, z, w.
    pub orientation: [f64; 4],
    /// World frame [m/s].
    pub velocity: [f64; 3],
    /// World frame [rad/s].
    pub angular_velocity: [f64; 3],
    /// [kg]; infinite for what stays where it is.
    pub mass: f64,
    /// About the principal axes [kg m^2].
    pub inertia: [f64; 3],
    /// Coulomb's coefficient.
    pub friction: f64,
    /// From 0 to 1.
    pub restitution: f64,
}

impl Body {
    /// Whether it stays where it is.
    pub fn is_static(&self) -> bool {
        self.mass.is_infinite()
    }
}

/// What falls.
pub struct Pile {
    /// Of a frame [s].
    pub dt: f64,
    /// [m/s^2]
    pub gravity: [f64; 3],
    pub bodies: Vec<Body>,
}

/// Position, orientation, velocity and angular velocity, as in [`Body`].
pub type State = [f32; 13];

/// Reads numbers from the front of a file's bytes.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk().ok_or(io::ErrorKind::UnexpectedEof)?;
        self.0 = rest;
        Ok(*head)
    }

    fn count(&mut self) -> io::Result<usize> {
        Ok(u32::from_le_bytes(self.take()?) as usize)
    }

    fn numbers<const N: usize>(&mut self) -> io::Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.take()?);
        }
        Ok(numbers)
    }

    /// With its kind before it, as `pile_file.py` numbers them.
    fn shape(&mut self) -> io::Result<Shape> {
        Ok(match self.count()? {
            0 => {
                let corners = self.count()?;
                Shape::Hull((0..corners).map(|_| self.numbers()).collect::<io::Result<_>>()?)
            }
            1 => Shape::Box(self.numbers()?),
            2 => {
                let [radius] = self.numbers()?;
                Shape::Ball(radius)
            }
            _ => return Err(io::ErrorKind::InvalidData.into()),
        })
    }
}

impl Pile {
    fn load(path: &str) -> io::Result<Self> {
        let bytes = fs::read(path)?;
        let mut reader = Reader(bytes.strip_prefix(MAGIC).ok_or(io::ErrorKind::InvalidData)?);
        let count = reader.count()?;
        let [dt] = reader.numbers()?;
        let gravity = reader.numbers()?;
        let mut bodies = Vec::with_capacity(count);
        for _ in 0..count {
            let shape = reader.shape()?;
            let (position, orientation) = (reader.numbers()?, reader.numbers()?);
            let (velocity, angular_velocity) = (reader.numbers()?, reader.numbers()?);
            let ([mass], inertia) = (reader.numbers()?, reader.numbers()?);
            let [friction, restitution] = reader.numbers()?;
            bodies.push(Body {
                shape,
                position,
                orientation,
                velocity,
                angular_velocity,
                mass,
                inertia,
                friction,
                restitution,
            });
        }
        Ok(Self { dt, gravity, bodies })
    }
}

/// An engine with a pile in it.
pub trait Engine {
    /// Name and version.
    const NAME: &str;

    /// Substeps of a step, as the engine comes.
    const SUBSTEPS: u32;

    fn build(pile: &Pile) -> Self;

    /// Advances by `dt` [s] in so many substeps.
    fn step(&mut self, dt: f64, substeps: u32);

    /// Of a body, by its place in the pile.
    fn state(&self, body: usize) -> State;
}

/// The whole of a program, whose arguments are `PILE FRAMES TIMES [STATES [SUBSTEPS [STEPS]]]`:
/// reads the pile, steps it, and writes the milliseconds of processor time of each frame, one on a
/// line, and after each the states of all bodies, little endian, if they are wanted. A frame is one
/// step unless it says otherwise, and a step has the engine's own number of substeps. Says on
/// stdout who it is, and then by how many KiB its memory grew at most.
///
/// # Errors
/// If a file cannot be read or written, or an argument is missing.
pub fn run<E: Engine>() -> io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let usage = || {
        let usage = "usage: PILE FRAMES TIMES [STATES [SUBSTEPS [STEPS]]]";
        io::Error::new(io::ErrorKind::InvalidInput, usage)
    };
    let number = |text: &String| text.parse::<u32>().map_err(|_| usage());
    let [path, frames, times, rest @ ..] = arguments.as_slice() else { return Err(usage()) };
    let frames = number(frames)?;
    let substeps = rest.get(1).map_or(Ok(E::SUBSTEPS), number)?;
    let steps = rest.get(2).map_or(Ok(1), number)?;
    let pile = Pile::load(path)?;
    let mut states = rest.first().map(fs::File::create).transpose()?.map(io::BufWriter::new);
    let memory = peak_memory();
    let mut engine = E::build(&pile);
    let mut lines = String::new();
    for _ in 0..frames {
        let begin = ProcessTime::now();
        for _ in 0..steps {
            engine.step(pile.dt / f64::from(steps), substeps);
        }
        let _ = writeln!(lines, "{:.6}", 1e3 * begin.elapsed().as_secs_f64());
        if let Some(file) = &mut states {
            for body in 0..pile.bodies.len() {
                for number in engine.state(body) {
                    file.write_all(&number.to_le_bytes())?;
                }
            }
        }
    }
    if let Some(mut file) = states {
        file.flush()?;
    }
    fs::write(times, lines)?;
    println!("{}\n{}", E::NAME, peak_memory() - memory);
    Ok(())
}

/// Largest resident set of this process so far [KiB]; 0 where the system does not say.
fn peak_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    peak.and_then(|peak| peak.trim().strip_suffix(" kB")?.parse().ok()).unwrap_or(0)
}
