//! A short run of every fuzz target: mutated examples, the same every time. The long runs are
//! `cargo bench --bench hostile -- 100000` and `cargo fuzz run TARGET`.

#[path = "../fuzz/mutate.rs"]
mod mutate;
#[path = "../fuzz/seeds.rs"]
mod seeds;
#[path = "../fuzz/targets.rs"]
mod targets;

/// Mutated inputs per target.
const COUNT: u64 = 1000;

#[test]
fn seeds_are_accepted() {
    for (name, run) in targets::ALL {
        for (i, seed) in seeds::of(name).iter().enumerate() {
            // Motions that refer to a table find none.
            let needs_file = name == "motion" && String::from_utf8_lossy(seed).contains("\nfile =");
            assert_eq!(run(seed), !needs_file, "{name} {i}");
        }
    }
}

#[test]
fn known_troublemakers_are_told_what_is_wrong() {
    for (name, run) in targets::ALL {
        for input in seeds::known(name) {
            run(&input);
        }
    }
}

#[test]
fn mutated_input_is_accepted_or_told_what_is_wrong() {
    for (name, run) in targets::ALL {
        let seeds = seeds::of(name);
        let mut accepted = 0;
        for index in 0..COUNT {
            let input = mutate::input(&seeds, index);
            let told = std::panic::catch_unwind(|| run(&input));
            let told = told.unwrap_or_else(|_| panic!("{name}: input {index} makes a panic"));
            accepted += u64::from(told);
        }
        // Both ways are walked.
        assert!(
            (1..COUNT).contains(&accepted),
            "{name}: {accepted} accepted"
        );
    }
}
