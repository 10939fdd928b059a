#!/bin/bash
# Whether `--max-time` is kept, in time and memory, for inputs at the ends of what is allowed: every one
# is designed with every limit. Prints a row a run and exits with 1 when one of them ends more than 2 s
# after its limit or takes more than 2 GB. For an idle machine.
set -u
cd "$(dirname "$0")/.."
limits=${*:-0.01 3 20}
cargo build --release --quiet || exit 1
mpcgear=$PWD/target/release/mpcgear
examples=$PWD/examples
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place" || exit 1

# Largest, with as many teeth, bands and samples as there may be; smallest; fewest teeth.
for example in uniform_1r stroke_1r1t trefoil wobble_lift_3r1t; do
    for size in "500 60 8 1000" "500 60 auto 1000" "15 6 12 4" "25 3 auto 36"; do
        read -r distance teeth pairs samples <<< "$size"
        [ "$pairs" = auto ] && pairs='"auto"'
        { cat "$examples/$example.toml"
          printf '\n[gear]\ncenter_distance_mm = %s.0\nteeth = %s\n' "$distance" "$teeth"
          printf 'sub_gear_pairs = %s\nsamples = %s\n' "$pairs" "$samples"
        } > "${example}_L${distance}_J${teeth}_K${pairs//\"/}.toml"
    done
done
# The longest formulas: five components of 19,000 letters of a Fourier series.
awk 'BEGIN {
    print "name = \"long\"\nclass = \"3R1T\"\n[motion]\nkind = \"formula\""
    for (c = 0; c < 5; c++) {
        sum = ""
        for (n = 1; length(sum) < 18900; n++) sum = sum sprintf("+1e-5*sin(%d*phi+%d)/%d^4", n, c, n)
        term[c] = sum
    }
    printf "own_turn = \"-phi%s\"\n", term[0]
    printf "axis = [\"%s\", \"%s\", \"1%s\"]\n", term[1], term[2], term[3]
    printf "translation = [\"0\", \"0\", \"%s\"]\n", term[4]
}' > long_formulas.toml
# As many poses as there may be.
printf 'name = "many"\nclass = "1R"\n[motion]\nkind = "table"\nfile = "many.csv"\n' > many_poses.toml
awk 'BEGIN {
    pi = atan2(0, -1); n = 99999; print "phi_deg,x,y,z,qw,qx,qy,qz"
    for (i = 0; i <= n; i++) { h = -pi * i / n; printf "%.6f,0,0,0,%.12f,0,0,%.12f\n", 360 * i / n, cos(h), sin(h) }
}' > many.csv

failed=0
printf '%-36s %7s %8s %8s %8s %5s\n' input limit_s wall_s cpu_s peak_mb exit
for motion in *.toml; do
    for limit in $limits; do
        /usr/bin/time -o time -f '%e %U %S %M' "$mpcgear" design "$motion" -o out --quiet --max-time "$limit" > out.txt 2> err.txt
        code=$?
        read -r wall user system peak <<< "$(tail -1 time)"
        verdict=$(awk -v w="$wall" -v l="$limit" -v p="$peak" -v c="$code" \
            'BEGIN { print (w > l + 2 || p > 2e6 || (c != 0 && c != 3)) ? "missed" : "" }')
        printf '%-36s %7s %8s %8.1f %8.0f %5s %s\n' "${motion%.toml}" "$limit" "$wall" \
            "$(awk "BEGIN { print $user + $system }")" "$(awk "BEGIN { print $peak / 1000 }")" "$code" "$verdict"
        [ -z "$verdict" ] || { failed=1; cat err.txt; }
        rm -rf out out.draft
    done
done
exit $failed
