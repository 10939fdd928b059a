#!/bin/sh
# How far the program reaches: designs the motions of benches/reach and random ones, every design proved on
# its meshes, and prints a Markdown table of what came out against what is wanted. A random class and level
# is wanted feasible in at least the given share. Exit code 1 when anything is missed.
# Usage: benches/reach.sh [OUTPUT-FOLDER [RANDOM-MOTIONS-A-ROW [FIRST-NUMBER]]]; 0 leaves the random ones out.
# MPCGEAR names another program to try.
set -eu
cd "$(dirname "$0")/.."
out=${1:-target/reach}
count=${2:-20}
first=${3:-1}
mkdir -p "$out"
if [ -z "${MPCGEAR:-}" ]; then
    cargo build --release --quiet
    MPCGEAR=target/release/mpcgear
fi
design() { # motion file; leaves summary.json in $out/NAME
    name=$(basename "$1" .toml)
    rm -rf "${out:?}/$name"
    "$MPCGEAR" --quiet design "$1" -o "$out/$name" >"$out/$name.log" 2>&1 || true
}
missed=0
echo '| motion | feasible | c | K | min Q (wanted) | min Q* (wanted) | time, s | what is wrong |'
echo '|---|---|---|---|---|---|---|---|'
row() { # name, least min Q, least min Q*
    design "benches/reach/$1.toml"
    python3 - "$out/$1" "$@" <<'PYTHON' || missed=1
import json, os, sys
folder, name, least, least_star = sys.argv[1:]
path = f"{folder}/summary.json"
if not os.path.exists(path):
    print(f"| {name} | **no** | | | | | | see {folder}.log |")
    sys.exit(1)
s = json.load(open(path))
good = s["feasible"]
def figure(value, wanted):
    global good
    text = "-" if value is None else f"{value:.2f}"
    if wanted == "-":
        return text
    reached = value is not None and s["feasible"] and value >= float(wanted)
    good = good and reached
    return f"{text} ({wanted}){'' if reached else ' **missed**'}"
print(f"| {name} | {'yes' if s['feasible'] else '**no**'} | {s['contact_ratio']:g} | {s['k']} "
      f"| {figure(s['q_min'], least)} | {figure(s['q_star_min'], least_star)} | {s['wall_seconds']:.0f} "
      f"| {'; '.join(s['problems'])[:160]} |")
sys.exit(0 if good else 1)
PYTHON
}
row cone_20 4 -
row rocking_20 6.7 -
row rocking_30 4 -
row cone_15_twice - -
row trefoil_15 3 -
row trefoil_20 1.5 -
row cone_8_lift_3 - 0.3
row stroke_5 - 0.4
row stroke_10 - 0.25
row speed_60 8.6 -
row speed_80 6 -
[ "$count" != 0 ] || exit "$missed"
echo
echo '| random motions | feasible (wanted) | least, mean min Q | least, mean min Q* (wanted) | mean, longest time, s |'
echo '|---|---|---|---|---|'
set_of() { # class, level, least share, least min Q*
    mkdir -p "$out/motions"
    python3 benches/reach/random.py "$1" "$2" "$first" "$count" "$out/motions"
    names=""
    for number in $(seq "$first" $((first + count - 1))); do
        name=$(python3 -c "print(f'random_{\"$1\".lower()}_{float(\"$2\"):g}_$number')")
        design "$out/motions/$name.toml"
        names="$names $name"
    done
    python3 - "$out" "$@" $names <<'PYTHON' || missed=1
import json, os, sys
out, joint, level, share, least, *names = sys.argv[1:]
paths = [f"{out}/{name}/summary.json" for name in names]
all_of = [json.load(open(p)) for p in paths if os.path.exists(p)]
works = [s for s in all_of if s["feasible"]]
def both(key):
    values = [s[key] for s in works]
    return (min(values), sum(values) / len(values)) if values else (float("nan"),) * 2
q, star = both("q_min"), both("q_star_min")
times = [s["wall_seconds"] for s in all_of] or [float("nan")]
reached = len(works) >= float(share) * len(names)
strong = least == "-" or star[0] >= float(least)
print(f"| {joint} level {level} | {len(works)} of {len(names)} ({share}){'' if reached else ' **missed**'} "
      f"| {q[0]:.2f}, {q[1]:.2f} | {star[0]:.3f}, {star[1]:.3f}{'' if least == '-' else f' ({least})'}"
      f"{'' if strong else ' **missed**'} | {sum(times) / len(times):.0f}, {max(times):.0f} |")
sys.exit(0 if reached and strong else 1)
PYTHON
}
set_of 3R1T 1 0.9 0.2
for joint in 1R 1R1T 3R 3R1T; do
    set_of "$joint" 1.5 0.9 -
    set_of "$joint" 2 0.7 -
done
exit "$missed"
