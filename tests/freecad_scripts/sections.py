"""Runs inside freecadcmd: the sketches of the teeth follow their parameters.

The add-on is installed; MPCGEAR_DESIGN is a design.json, MPCGEAR_EXPECTED a list of
[alias, value, area of every pair's section, highest and lowest corner]; exit code 0 when all holds.
"""

import json
import os
import sys
import traceback

import FreeCAD as App
import Part

from freecad.mpcgear import open_design, parameters, sections


def agrees(sketch, area, high, low):
    face = Part.Face(Part.Wire(Part.__sortEdges__(sketch.Shape.Edges)))
    box = sketch.Shape.BoundBox
    found = [face.Area, box.YMax, box.YMin]
    for a, b in zip(found, (area, high, low)):
        assert abs(a - b) < 2e-4, (sketch.Label, found, (area, high, low))


def main():
    design = open_design.read(os.environ["MPCGEAR_DESIGN"])
    document = App.newDocument("Sections")
    parameters.build_parameters(document, design)
    outlines = parameters.tooth_sections(design)
    sketches = [sections.ToothSection(document, s, k).sketch for k, s in enumerate(outlines, 1)]
    document.recompute()
    table = document.ToothParams
    for alias, value, areas, highs, lows in json.loads(os.environ["MPCGEAR_EXPECTED"]):
        cell = table.getCellFromAlias(alias)
        before = table.getContents(cell)
        table.set(cell, "=%.9f mm" % value)
        document.recompute()
        for sketch, *expected in zip(sketches, areas, highs, lows):
            assert sketch.FullyConstrained, (alias, value, sketch.Label)
            agrees(sketch, *expected)
        table.set(cell, before)
        document.recompute()
        print("agrees:", alias, value)


try:
    main()
    code = 0
except BaseException:  # freecadcmd would run the file again and exit with 0
    traceback.print_exc()
    code = 1
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)
