#!/bin/sh
# Designs the examples one after the other and prints a Markdown table of what came out against what
# is asked for ("-" is nothing), then makes their cards anew. Exit code 1 when anything is missed.
# Usage: benches/examples.sh [OUTPUT-FOLDER]; needs GNU time and Python 3.
set -eu
cd "$(dirname "$0")/.."
out=${1:-target/examples}
mkdir -p "$out"
cargo build --release --quiet
echo '| example | K | min Q (wanted) | time, s (at most) | CPU, s | peak memory, MB | feasible | residual, mm/rad | problems |'
echo '|---|---|---|---|---|---|---|---|---|'
missed=0
design() { # name, least min Q, most seconds
    code=0
    /usr/bin/time -o "$out/$1.time" -f '%e %U %M' \
        target/release/mpcgear --quiet design "examples/$1.toml" -o "$out/$1" || code=$?
    folder="$out/$1"
    # A draft goes beside an older design.
    [ "$code" = 0 ] || [ ! -d "$folder.draft" ] || folder="$folder.draft"
    python3 - "$folder/summary.json" "$out/$1.time" "$@" <<'PYTHON' || missed=1
import json, sys
summary, time, name, least, most = sys.argv[1:]
s = json.load(open(summary))
wall, user, memory = open(time).read().split("\n")[-2].split()
missed = []
def tick(good):
    if not good:
        missed.append(name)
    return "" if good else " **missed**"
q = s["q_min"] or float("-inf")
print(f"| {name} | {s['k']} | {q:.2f} ({least}){tick(least == '-' or q >= float(least))} "
      f"| {float(wall):.0f} ({most}){tick(most == '-' or float(wall) <= float(most))} | {float(user):.0f} "
      f"| {int(memory) / 1024:.0f}{tick(int(memory) < 1.5e6)} | {'yes' if s['feasible'] else '**no**'} "
      f"| {s['conjugation_residual_max'] or float('nan'):.1e} | {'; '.join(s['problems'])} |")
sys.exit(1 if missed or not s["feasible"] else 0)
PYTHON
    target/release/mpcgear --quiet export "$folder" --to card -o examples/cards
}
design uniform_1r 9 30
design quick_return_1r 7 30
design stroke_1r1t 0.35 60
design trefoil 3.0 120
design wobble_lift_3r1t 0.12 240
design paddle_table_1r1t - -
design pick_and_place_3r - -
design polisher_path_3r - -
design camera_head_3r - -
design stirrer_1r1t - -
design press_1r - -
design tray_3r - -
design flapping_wing_3r - -
design stirrer_20_10_1r - -
design trefoil_20_10 - -
exit "$missed"
