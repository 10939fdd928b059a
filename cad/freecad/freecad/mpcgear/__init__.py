"""FreeCAD add-on of mpcgear: gear mechanisms that follow a motion. Importing it starts nothing."""
