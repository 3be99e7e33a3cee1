//! Many jobs in parallel.

use std::ops::ControlFlow;
use std::sync::{
    Mutex,
    atomic::{AtomicBool, Ordering},
    mpsc,
};
use std::time::{Duration, Instant};

use super::{Case, Findings, Method, Stopped};
use crate::scene::shapes;

/// Time between two progress reports of a job.
const INTERVAL: Duration = Duration::from_millis(100);

/// A case with a method at a resolution.
#[derive(Debug, Clone, Copy)]
pub struct Job {
    /// The case.
    pub case: &'static Case,
    /// The method.
    pub method: &'static Method,
    /// Particles over the characteristic length of the case.
    pub resolution: u32,
}

/// Result of a job.
#[derive(Debug)]
pub struct Outcome {
    /// The job.
    pub job: Job,
    /// Wall time \[s].
    pub seconds: f64,
    /// Its findings, or why it failed.
    pub result: Result<Findings, Stopped>,
}

/// Progress of the jobs.
pub enum Event<'a> {
    /// A job took a step.
    Step {
        /// The job.
        job: &'a Job,
        /// Completed fraction of all jobs, 0 to 1, by an estimate of their work.
        fraction: f64,
    },
    /// A job is finished.
    Done {
        /// Its number.
        number: usize,
        /// Outcomes of the finished jobs, in the order of the jobs.
        outcomes: &'a [Option<Outcome>],
    },
}

impl Job {
    /// Estimated work of the job: particles times steps of a weakly compressible method.
    fn work(&self) -> f64 {
        let Ok(scene) = self.case.scene(self.method, self.resolution) else {
            return 1.0;
        };
        let mut particles = 0.0;
        shapes::for_each_particle(&scene, |_| particles += 1.0);
        particles * f64::from(scene.duration * self.case.sound_speed / scene.spacing)
    }
}

enum Word {
    Step(usize, f64),
    Done(usize, Outcome),
}

/// Runs jobs on `threads` threads, one thread per job, the longest first. `tell` may stop the queue: jobs that are not
/// finished by then return `None`.
///
/// ```no_run
/// use std::ops::ControlFlow;
///
/// use overfall::validate::{CASES, Job, METHODS, run_all};
///
/// let job = Job { case: CASES[0], method: &METHODS[2], resolution: CASES[0].resolution };
/// for outcome in run_all(&[job], 1, &mut |_| ControlFlow::Continue(())).into_iter().flatten() {
///     for figure in outcome.result.expect("a run to its end").figures {
///         let _ = (figure.quantity.as_str(), figure.measured, figure.known, figure.error());
///     }
/// }
/// ```
pub fn run_all(
    jobs: &[Job],
    threads: usize,
    tell: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Vec<Option<Outcome>> {
    let works: Vec<f64> = jobs.iter().map(Job::work).collect();
    let all: f64 = works.iter().sum();
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by(|&a, &b| works[a].total_cmp(&works[b]));
    let (left, stop) = (Mutex::new(order), AtomicBool::new(false));
    let mut outcomes: Vec<Option<Outcome>> = jobs.iter().map(|_| None).collect();
    let mut done = vec![0.0; jobs.len()];
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads.clamp(1, jobs.len().max(1)) {
            let (send, left, stop) = (send.clone(), &left, &stop);
            scope.spawn(move || work(jobs, left, stop, &send));
        }
        drop(send);
        for word in receive {
            let flow = match word {
                Word::Step(number, fraction) => {
                    done[number] = fraction;
                    let sum: f64 = done.iter().zip(&works).map(|(part, of)| part * of).sum();
                    tell(Event::Step {
                        job: &jobs[number],
                        fraction: sum / all,
                    })
                }
                Word::Done(number, outcome) => {
                    done[number] = 1.0;
                    outcomes[number] = Some(outcome);
                    tell(Event::Done {
                        number,
                        outcomes: &outcomes,
                    })
                }
            };
            if flow.is_break() {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    outcomes
}

/// Runs jobs until none is left.
fn work(jobs: &[Job], left: &Mutex<Vec<usize>>, stop: &AtomicBool, send: &mpsc::Sender<Word>) {
    while !stop.load(Ordering::Relaxed) {
        let next = left.lock().unwrap_or_else(|lock| lock.into_inner()).pop();
        let Some(number) = next else {
            return;
        };
        let job = jobs[number];
        let started = Instant::now();
        let mut said = started;
        let result = job
            .case
            .run(job.method, job.resolution, 1, &mut |fraction| {
                if said.elapsed() >= INTERVAL {
                    said = Instant::now();
                    // The receiver was dropped: the jobs are stopped.
                    if send.send(Word::Step(number, fraction)).is_err() {
                        return ControlFlow::Break(());
                    }
                }
                if stop.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            });
        if matches!(result, Err(Stopped::Asked)) {
            return;
        }
        let outcome = Outcome {
            job,
            seconds: started.elapsed().as_secs_f64(),
            result,
        };
        if send.send(Word::Done(number, outcome)).is_err() {
            return;
        }
    }
}
