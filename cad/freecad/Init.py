"""Nothing to start without the GUI: `import mpcgear` works as it is."""
