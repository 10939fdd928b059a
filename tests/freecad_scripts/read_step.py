"""Reads a STEP file with build123d and prints one line per solid: the assembly that it belongs to, name, number of
solids, validity, volume in mm³, colour (red, green, blue in per cent); and before them the root's name."""

import sys

from build123d import import_step

with open(sys.argv[1], encoding="latin-1") as source:
    head = source.read(4000)
assert "AUTOMOTIVE_DESIGN" in head or "AP242" in head, "neither AP214 nor AP242"
read = import_step(sys.argv[1])
print(read.label)


def tell(assembly):
    for child in assembly.children:
        if child.children:
            tell(child)
            continue
        solids = child.solids()
        valid = child.is_valid() if callable(child.is_valid) else child.is_valid
        print(assembly.label, child.label, len(solids), valid, sum(s.volume for s in solids),
              *(round(100 * share) for share in tuple(child.color)[:3]), sep="\t")


tell(read)
