"""FreeCAD add-on of mpcgear: gear mechanisms from a design.json."""
