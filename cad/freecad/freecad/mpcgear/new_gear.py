"""The task panel *New gear…*: motion, settings, plot, draft, design. What it asks for is done by `jobs`."""

import os

import FreeCAD as App
import FreeCADGui as Gui
from PySide import QtCore, QtGui

from . import files, jobs, motions, open_design, program, redesign
from .motions import MotionError
from .plot import MotionPlot
from .progress import Cancelled
from .program import ProgramError

POLL_MS = 200
EXAMPLES = ("trefoil", "pick_and_place_3r", "flapping_wing_3r", "uniform_1r", "quick_return_1r", "stroke_1r1t",
            "wobble_lift_3r1t", "trefoil_20_10", "stirrer_20_10_1r")
PREVIEW = "MpcgearDraft"
translate = App.Qt.translate


class NewGearPanel:
    """Chooses a motion, looks at it, drafts and designs. With a `document` it designs that gear anew."""

    def __init__(self, document=None):
        self.document, self.job, self.poses = document, None, []
        self.given = None if document is None else redesign.motion_text(document)
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(translate("mpcgear", "Redesign") if document else translate("mpcgear", "New gear"))
        layout = QtGui.QVBoxLayout(self.form)
        layout.addWidget(self.motion_box())
        layout.addWidget(self.settings_box())
        layout.addWidget(self.run_box())
        self.timer = QtCore.QTimer()
        self.timer.timeout.connect(self.poll)

    # --- widgets ---------------------------------------------------------------------------------

    def motion_box(self):
        """Class and source of the motion, with a page for each kind of source."""
        box = QtGui.QGroupBox(translate("mpcgear", "Motion"))
        rows = QtGui.QFormLayout(box)
        self.plot, self.verdict = MotionPlot(), QtGui.QLabel()
        self.source, self.pages = QtGui.QComboBox(), QtGui.QStackedWidget()
        self.gear_class = QtGui.QComboBox()
        self.gear_class.addItems(motions.CLASSES)
        self.gear_class.setCurrentIndex(2)
        self.gear_class.setToolTip(translate("mpcgear", "What the follower may do: turn about z (1R), turn and slide "
                                             "(1R1T), turn in any way (3R), the same and slide (3R1T)"))
        pages = [
            (translate("mpcgear", "Example"), self.example_page(), self.from_example),
            (translate("mpcgear", "Formulas"), self.formula_page(), self.from_formulas),
            (translate("mpcgear", "CSV file"), self.csv_page(), self.from_csv),
            (translate("mpcgear", "Path: selected edges"), self.path_page(), self.from_path),
            (translate("mpcgear", "Recorded poses"), self.poses_page(), self.from_poses),
        ]
        if self.given is not None:
            page = QtGui.QLabel(translate("mpcgear", "The motion that this gear was made for, and its settings."))
            page.setWordWrap(True)
            pages.insert(0, (translate("mpcgear", "As it is"), page, lambda: (self.given, 0.0)))
        self.sources = [read for _, _, read in pages]
        for words, page, _ in pages:
            self.source.addItem(words)
            self.pages.addWidget(page)
        self.source.currentIndexChanged.connect(self.choose)
        rows.addRow(translate("mpcgear", "Source"), self.source)
        self.class_label = QtGui.QLabel(translate("mpcgear", "Class"))
        rows.addRow(self.class_label, self.gear_class)
        rows.addRow(self.pages)
        look = QtGui.QPushButton(translate("mpcgear", "Look at the motion"))
        look.clicked.connect(lambda: self.guarded(self.look))
        self.verdict.setWordWrap(True)
        for widget in (look, self.plot, self.verdict):
            rows.addRow(widget)
        self.choose(0)
        return box

    def example_page(self):
        self.example = QtGui.QComboBox()
        self.example.addItems(EXAMPLES)
        self.example.currentIndexChanged.connect(lambda _: self.forget_plot())
        return page((translate("mpcgear", "Name"), self.example))

    def formula_page(self):
        self.own_turn = QtGui.QLineEdit("-phi")
        self.rotation = [QtGui.QLineEdit(text) for text in ("7*deg*sin(phi)", "4*deg*sin(2*phi)", "")]
        self.slide = QtGui.QLineEdit()
        self.own_turn.setToolTip(translate("mpcgear", "Turn about the follower's own axis, rad, of phi; -1 turn a turn"))
        self.slide.setToolTip(translate("mpcgear", "Height of the joint, mm, for example 2*sin(phi); 1R1T and 3R1T"))
        for field in self.rotation:
            field.setToolTip(translate("mpcgear", "Then an axis-angle vector, rad; 3R and 3R1T"))
        return page((translate("mpcgear", "Own turn"), self.own_turn),
                    *zip((translate("mpcgear", "Tilt about x"), translate("mpcgear", "about y"),
                          translate("mpcgear", "about z")), self.rotation),
                    (translate("mpcgear", "Slide"), self.slide))

    def csv_page(self):
        self.csv = QtGui.QLineEdit()
        browse = QtGui.QPushButton("…")
        browse.clicked.connect(self.browse)
        row = QtGui.QHBoxLayout()
        row.addWidget(self.csv)
        row.addWidget(browse)
        words = QtGui.QLabel(translate("mpcgear", "Poses: phi_deg, x, y, z, qw, qx, qy, qz. Path of a point: x, y, z, or "
                                       "phi_deg, x, y, z. One turn of the driver, mm."))
        words.setWordWrap(True)
        return page((translate("mpcgear", "File"), row), (words,))

    def path_page(self):
        self.path_centre = centre_fields()
        words = QtGui.QLabel(translate("mpcgear", "Select a closed sketch, or edges, before you look at the motion. The "
                                       "end-effector goes along it once per turn, at constant speed."))
        words.setWordWrap(True)
        return page((words,), (translate("mpcgear", "Joint at, mm"), row_of(self.path_centre)))

    def poses_page(self):
        self.pose_centre = centre_fields()
        self.pose_count = QtGui.QLabel()
        self.record_button = QtGui.QPushButton(translate("mpcgear", "Record"))
        self.record_button.clicked.connect(lambda: self.guarded(self.record))
        clear = QtGui.QPushButton(translate("mpcgear", "Clear"))
        clear.clicked.connect(self.clear_poses)
        row = QtGui.QHBoxLayout()
        for widget in (self.record_button, clear, self.pose_count):
            row.addWidget(widget)
        words = QtGui.QLabel(translate("mpcgear", "Select an object, press Record, move it, press Record again, and so on "
                                       "evenly over one turn of the driver. The first pose is the follower at rest, "
                                       "with its axis along z through the joint."))
        words.setWordWrap(True)
        self.clear_poses()
        return page((words,), (row,), (translate("mpcgear", "Joint at, mm"), row_of(self.pose_centre)))

    def settings_box(self):
        """The settings that are changed most; others by their names."""
        box = QtGui.QGroupBox(translate("mpcgear", "Settings (empty: as they are)"))
        rows = QtGui.QFormLayout(box)
        self.settings = {}
        for path, words, tip in (
            ("gear.center_distance_mm", translate("mpcgear", "Centre distance, mm"), "25"),
            ("gear.teeth", translate("mpcgear", "Teeth of a band"), "10"),
            ("fit.clearance_mm", translate("mpcgear", "Clearance, mm"), "0.1"),
            ("load.mass_g", translate("mpcgear", "Load, g"), "100"),
            ("load.payload_at_least_g", translate("mpcgear", "Must carry, g"), "0"),
            ("load.point_mm", translate("mpcgear", "Load point, mm"), "[0.0, 0.0, 60.0]"),
            ("search.effort", translate("mpcgear", "Effort of the search"), "1.0"),
        ):
            self.settings[path] = QtGui.QLineEdit()
            self.settings[path].setPlaceholderText(tip)
            self.settings[path].setToolTip(path)
            self.settings[path].setMinimumWidth(40)
            rows.addRow(words, self.settings[path])
        self.others = QtGui.QLineEdit()
        self.others.setToolTip(translate("mpcgear", "Any setting by its name, separated by semicolons"))
        self.others.setPlaceholderText("fit.profile=\"fdm_0.4\"; hub.mount_radius_mm=9")
        rows.addRow(translate("mpcgear", "Others"), self.others)
        return box

    def run_box(self):
        """Program, buttons, progress."""
        box = QtGui.QGroupBox(translate("mpcgear", "Design"))
        rows = QtGui.QFormLayout(box)
        self.program = QtGui.QLineEdit(program.preferences().GetString("Program", ""))
        try:
            self.program.setPlaceholderText(program.find())
        except ProgramError:
            self.program.setPlaceholderText("mpcgear")
        self.program.editingFinished.connect(
            lambda: program.preferences().SetString("Program", self.program.text().strip()))
        rows.addRow(translate("mpcgear", "Program"), self.program)
        self.draft_button = QtGui.QPushButton(translate("mpcgear", "Draft"))
        self.draft_button.setToolTip(translate("mpcgear", "A first look in a few seconds, neither polished nor proved"))
        self.draft_button.clicked.connect(lambda: self.guarded(lambda: self.start(True)))
        self.design_button = QtGui.QPushButton(translate("mpcgear", "Design"))
        self.design_button.clicked.connect(lambda: self.guarded(lambda: self.start(False)))
        self.cancel_button = QtGui.QPushButton(translate("mpcgear", "Cancel"))
        self.cancel_button.clicked.connect(self.cancel)
        row = QtGui.QHBoxLayout()
        for button in (self.draft_button, self.design_button, self.cancel_button):
            button.setMinimumWidth(40)
            row.addWidget(button)
        rows.addRow(row)
        self.bar, self.words = QtGui.QProgressBar(), QtGui.QLabel()
        self.bar.setRange(0, 1000)
        self.words.setWordWrap(True)
        rows.addRow(self.bar)
        rows.addRow(self.words)
        self.set_busy(False)
        return box

    # --- what the widgets say ----------------------------------------------------------------------

    def choose(self, index):
        """Another source has been chosen."""
        self.pages.setCurrentIndex(index)
        has_own = self.sources[index] == self.from_example or (self.given is not None and index == 0)
        for widget in (self.class_label, self.gear_class):
            widget.setVisible(not has_own)
        self.forget_plot()

    def forget_plot(self):
        """What was drawn is no longer what is chosen."""
        self.plot.show_course({})
        self.verdict.setText("")

    def text(self):
        """The motion file that the panel describes; tells how far points or poses had to be moved."""
        text, moved = self.sources[self.source.currentIndex()]()
        self.moved = moved
        return text

    def from_example(self):
        return jobs.example(self.example.currentText()), 0.0

    def from_formulas(self):
        gear_class = self.gear_class.currentText()
        motion = motions.formula(gear_class, self.own_turn.text(), [f.text() for f in self.rotation],
                                 self.slide.text())
        return motions.motion_file("my_gear", gear_class, motion), 0.0

    def from_csv(self):
        name = os.path.splitext(os.path.basename(self.csv.text()))[0] or "my_gear"
        return motions.motion_file(name, self.gear_class.currentText(), motions.table(self.csv.text())), 0.0

    def from_path(self):
        edges = selected_edges()
        gear_class = self.gear_class.currentText()
        motion, moved = motions.along(edges, vector_of(self.path_centre), gear_class)
        return motions.motion_file("path_gear", gear_class, motion), moved

    def from_poses(self):
        gear_class = self.gear_class.currentText()
        motion, moved, _ = motions.recorded(self.poses, vector_of(self.pose_centre), gear_class)
        return motions.motion_file("recorded_gear", gear_class, motion), moved

    def changes(self):
        """Settings that are not empty, as PATH=VALUE."""
        named = ["%s=%s" % (path, field.text().strip()) for path, field in self.settings.items()
                 if field.text().strip()]
        return named + [part.strip() for part in self.others.text().split(";") if part.strip()]

    # --- what the buttons do -----------------------------------------------------------------------

    def guarded(self, action):
        """Does `action`; what it refuses is said in the panel."""
        try:
            action()
        except (ProgramError, MotionError, open_design.DesignError, redesign.NotRedesigned) as error:
            self.words.setText(str(error))
        except Cancelled:
            self.words.setText(translate("mpcgear", "Cancelled."))

    def browse(self):
        path, _ = QtGui.QFileDialog.getOpenFileName(self.form, translate("mpcgear", "Motion"), "", "CSV (*.csv)")
        if path:
            self.csv.setText(path)

    def record(self):
        """Takes the pose of the one selected object."""
        selected = Gui.Selection.getSelection()
        if len(selected) != 1 or not hasattr(selected[0], "getGlobalPlacement"):
            raise MotionError(translate("mpcgear", "Select the one object whose pose is to be recorded."))
        self.poses.append(selected[0].getGlobalPlacement())
        self.pose_count.setText(translate("mpcgear", "%d poses") % len(self.poses))

    def clear_poses(self):
        self.poses = []
        self.pose_count.setText(translate("mpcgear", "no poses yet"))

    def look(self):
        """Draws the motion and says what it means for the search."""
        job = jobs.Job(self.text(), self.changes())
        self.plot.show_course(job.course())
        figures = job.figures()
        words = translate("mpcgear", "Class %s, least class %s; tilt up to %.1f°; sharpness %.1f mm/rad²: %s.") % (
            figures["class"], figures["least_class"], figures["tilt_max_deg"],
            figures["sharpness"]["most_mm_rad2"], figures["verdict"])
        if self.moved > 0.05:
            words += translate("mpcgear", " The class cannot do all of it: moved by up to %.2f mm.") % self.moved
        self.verdict.setText(words)

    def start(self, draft):
        """Begins a draft or a design."""
        self.job = jobs.Job(self.text(), self.changes())
        self.job.start(draft)
        self.forget_plot()  # so that progress and Cancel can be seen
        self.set_busy(True)
        self.timer.start(POLL_MS)

    def poll(self):
        """The timer: shows how far the run is; takes over what it has made."""
        running = self.job.run.is_running()
        self.bar.setValue(int(1000 * self.job.run.progress.get("done", 0.0)))
        self.words.setText(jobs.state(self.job.run.progress))
        if not running:
            self.timer.stop()
            self.set_busy(False)
            self.guarded(self.finish)

    def finish(self):
        """Shows what was made: of a draft its bodies, of a design its tree."""
        path, summary = self.job.result()
        self.words.setText(jobs.told(summary))
        close(PREVIEW)
        if self.job.is_draft:
            preview(os.path.dirname(path))
        elif self.document is None:
            files.show(open_design.open_design(path))
        else:
            redesign.redesign(self.document, path)
            files.show(self.document)

    def cancel(self):
        """Asks the program to end with the best that it has."""
        if self.job is not None:
            self.job.run.stop()
            self.words.setText(translate("mpcgear", "Stopping…"))

    def set_busy(self, busy):
        """While the program works, only Cancel can be pressed."""
        self.draft_button.setEnabled(not busy)
        self.design_button.setEnabled(not busy)
        self.cancel_button.setEnabled(busy)
        self.bar.setVisible(busy)

    def getStandardButtons(self):
        """A Close button only; an int in 0.20, taken as such by 1.x too."""
        close_button = QtGui.QDialogButtonBox.Close
        return int(getattr(close_button, "value", close_button))

    def reject(self):
        """The panel is closed; a run under way is ended."""
        self.timer.stop()
        if self.job is not None and self.job.run is not None:
            self.job.run.kill()
        close(PREVIEW)
        Gui.Control.closeDialog()
        return True


def page(*rows):
    """A widget with rows of a label and a field, or of a field alone."""
    widget = QtGui.QWidget()
    layout = QtGui.QFormLayout(widget)
    layout.setContentsMargins(0, 0, 0, 0)
    for row in rows:
        layout.addRow(*row)
    return widget


def centre_fields():
    """Three numbers for the joint's centre."""
    fields = []
    for axis in "xyz":
        field = QtGui.QDoubleSpinBox()
        field.setRange(-1e4, 1e4)
        field.setPrefix(axis + " ")
        field.setButtonSymbols(QtGui.QAbstractSpinBox.NoButtons)
        field.setMinimumWidth(40)
        fields.append(field)
    return fields


def row_of(fields):
    """Fields side by side."""
    row = QtGui.QHBoxLayout()
    for field in fields:
        row.addWidget(field)
    return row


def vector_of(fields):
    """The vector that three fields hold."""
    return App.Vector(*(field.value() for field in fields))


def selected_edges():
    """Edges that are selected, or all of the selected objects, where they stand in the document."""
    edges = []
    for chosen in Gui.Selection.getSelectionEx("", 0):
        names = [name for name in chosen.SubElementNames if name.rsplit(".", 1)[-1].startswith("Edge")]
        placement = chosen.Object.getGlobalPlacement().multiply(chosen.Object.Placement.inverse())
        found = [chosen.Object.getSubObject(name) for name in names] if names else chosen.Object.Shape.Edges
        for edge in found:
            edge = edge.copy()
            edge.Placement = placement.multiply(edge.Placement)
            edges.append(edge)
    if not edges:
        raise MotionError(translate("mpcgear", "Select a closed sketch or edges first."))
    return edges


def preview(folder):
    """Shows the bodies of a draft in a document of their own."""
    import Mesh

    document = App.newDocument(PREVIEW, translate("mpcgear", "Draft"))
    for name, colour in files.COLOURS.items():
        path = os.path.join(folder, "meshes", name + ".stl")
        if os.path.isfile(path):
            body = document.addObject("Mesh::Feature", name.title())
            body.Mesh = Mesh.Mesh(path)
            body.ViewObject.ShapeColor = colour
    document.recompute()
    view = Gui.getDocument(document.Name).activeView()
    view.viewIsometric()
    view.fitAll()


def close(name):
    """Closes a document if it is open."""
    if name in App.listDocuments():
        App.closeDocument(name)
