"""Reads a STEP file with build123d and prints one line per solid: name, validity, volume in mm³."""

import sys

from build123d import import_step

with open(sys.argv[1], encoding="latin-1") as source:
    head = source.read(4000)
assert "AUTOMOTIVE_DESIGN" in head or "AP242" in head, "neither AP214 nor AP242"
read = import_step(sys.argv[1])
for child in read.children or [read]:
    solids = child.solids()
    valid = child.is_valid() if callable(child.is_valid) else child.is_valid
    print(child.label, len(solids), valid, sum(s.volume for s in solids), sep="\t")
