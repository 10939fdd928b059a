#!/bin/bash
# What a kill or a second writer can do to an output folder. Every run is killed (SIGKILL) at the N-th
# system call of a kind that changes the disk, for every kind and every N until the run gets through;
# then two runs write into one folder at the same time, again and again. Needs strace.
# Prints the number of kill points and rounds, and exits with 1 if a design was lost or mixed.
set -u
cd "$(dirname "$0")/.."
rounds=${1:-200}
cargo build --release --quiet || exit 1
mpcgear=$PWD/target/release/mpcgear
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place" || exit 1

# A run that only has a draft to write: a follower that makes no turn is refused at once. Beside the
# design in `out` the draft goes to `out.draft`, and replaces the one that is there.
motion() {
    printf 'name = "%s"\nclass = "1R"\n[motion]\nkind = "formula"\nown_turn = "0.2*sin(phi)"\n' "$1" > "$1.toml"
}
run() { "${@:2}" "$mpcgear" design "$1.toml" --quiet -o out > /dev/null 2> err.txt; }
name() { grep -o '"name": *"[a-z]*"' "$1" | head -1 | grep -o '[a-z]*"$'; }
whole() {
    [ -f "$draft/design.json" ] && [ -f "$draft/summary.json" ] \
        && [ "$(cat "$draft/notes/mine.txt")" = mine ] \
        && [ "$(name "$draft/design.json")" = "$(name "$draft/summary.json")" ]
}

draft=out.draft
motion old; motion new
run old; run old
mkdir "$draft/notes"; echo mine > "$draft/notes/mine.txt"
whole || { echo "no draft to begin with"; exit 1; }
kills=0 lost=0
for call in mkdir rename renameat renameat2 link linkat unlink unlinkat rmdir openat write chmod fchmod; do
    n=0
    while :; do
        n=$((n + 1))
        { run new strace -f -qq -o /dev/null -e "inject=$call:signal=KILL:when=$n"; } 2> /dev/null
        [ $? -eq 137 ] || break
        kills=$((kills + 1))
        whole || { lost=$((lost + 1)); echo "lost at $call $n"; ls -A "$draft"; }
    done
done
run old; whole || lost=$((lost + 1))
left=$(find . -name '.mpcgear-*' | wc -l)
echo "kill points tried: $kills, designs lost: $lost, hidden files left after the next run: $left"

mixed=0 refused=0
for _ in $(seq "$rounds"); do
    run old & a=$!
    run new & b=$!
    for job in $a $b; do
        wait "$job"; [ $? -eq 2 ] && refused=$((refused + 1))
    done
    whole || { mixed=$((mixed + 1)); }
done
echo "rounds with two writers: $rounds, refused: $refused, folders mixed: $mixed"
[ "$lost" -eq 0 ] && [ "$mixed" -eq 0 ] && [ "$left" -eq 0 ]
