//! Many trials on all cores, with the same result on any number of them.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// The random numbers of one trial: a stream of its own (ChaCha8 with the trial as its stream number) under a seed
/// made of the study's seed and the name of the experiment.
pub fn random(seed: u64, experiment: &str, trial: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ hash(experiment));
    random.set_stream(trial);
    random
}

/// Does `trials` trials; the outcomes come in the order of the trials.
pub fn run<O: Send>(
    seed: u64,
    experiment: &str,
    trials: u64,
    trial: impl Fn(u64, ChaCha8Rng) -> O + Sync + Send,
) -> Vec<O> {
    (0..trials).into_par_iter().map(|index| trial(index, random(seed, experiment, index))).collect()
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo): two experiments never share their numbers.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn outcomes_do_not_hang_on_the_number_of_cores() {
        let draw = || run(7, "test", 500, |index, mut random| (index, random.random::<u64>()));
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(draw);
        let many = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap().install(draw);
        assert_eq!(alone, many);
        assert!(alone.windows(2).all(|pair| pair[0].1 != pair[1].1), "every trial draws its own numbers");
    }

    #[test]
    fn experiments_and_seeds_draw_different_numbers() {
        let first = |seed, name| random(seed, name, 3).random::<u64>();
        assert_ne!(first(1, "a"), first(1, "b"));
        assert_ne!(first(1, "a"), first(2, "a"));
    }
}
