#!/bin/sh
# Guards the speed without a clock: counts the instructions of a small design of each class (callgrind, one
# thread) and compares them with benches/instructions.csv. Exit code 1 when one grew by more than 3 %; those that
# changed on purpose are written anew with --write, and the change is told in the commit.
# Usage: benches/instructions.sh [--write]; needs valgrind, takes about ten minutes.
set -eu
cd "$(dirname "$0")/.."
known=benches/instructions.csv
command -v valgrind >/dev/null || { echo "instructions.sh: please install valgrind" >&2; exit 1; }
cargo build --release --quiet
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
count() { # example, settings; prints millions of instructions
    example=$1
    shift
    RAYON_NUM_THREADS=1 valgrind --tool=callgrind --callgrind-out-file=/dev/null --log-file="$out/log" \
        target/release/mpcgear --quiet design "examples/$example.toml" "$@" -o "$out/$example" >/dev/null || [ $? = 3 ]
    rm -rf "$out/$example"
    sed -n 's/.*Collected : \([0-9]*\).*/\1/p' "$out/log" | awk '{ printf "%.0f", $1 / 1e6 }'
}
echo 'what,millions_of_instructions' >"$out/now.csv"
for example in uniform_1r stroke_1r1t trefoil wobble_lift_3r1t; do
    echo "$example first look,$(count "$example" --draft)" >>"$out/now.csv"
    echo "$example design at effort 0.05,$(count "$example" --effort 0.05)" >>"$out/now.csv"
done
if [ "${1-}" = --write ]; then
    cp "$out/now.csv" "$known"
    exit 0
fi
awk -F, 'NR == FNR { was[$1] = $2; next }
    FNR == 1 { print "| what | millions of instructions | before | change |"; print "|---|---|---|---|"; next }
    { change = was[$1] ? 100 * ($2 / was[$1] - 1) : 0; grown = change > 3 || !was[$1]; bad += grown
      printf "| %s | %d | %s | %+.1f %%%s |\n", $1, $2, was[$1], change, grown ? " **grown**" : "" }
    END { exit bad > 0 }' "$known" "$out/now.csv"
