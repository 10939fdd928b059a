# --- Parameters: a spreadsheet per body, and recipe expressions that follow them -----------------

import ast
import re

# (alias and key in the design's section, words, what a change does)
SECTION_ROWS = [
    ("thickness", "Tooth thickness along the contact normal",
     "changes the gap behind the tooth: run 'Check clearance here' after it"),
    ("tip", "Tooth height beyond the contact point",
     "a lower tip is harmless; drives the section only where the tip is flat"),
    ("root", "Depth of the section behind the contact point",
     "harmless while the rib still covers it"),
    ("clearance", "Gap between the flanks at the contact, half of it on each gear",
     "zero is the exact contact; more is play"),
    ("rib", "Thickness of the rib between tooth and hub", "harmless while thinner than the tooth"),
    ("rib_foot", "Thickness of the rib at its foot in the hub",
     "equal to the rib's for straight spokes, larger for tapered ones; harmless while thinner than "
     "the tooth"),
]

# The tooth's section as mpcgear's meshes have it: what of a flat flank is no edge (rad), the sharpest
# edge and the narrowest tip between edges (mm).
FLANK, SHARPEST, NARROWEST = 0.15, 0.2, 0.1


COMMON, TEETH = "Params", "ToothParams"
LAST_ROW = 120  # of a sheet, more than any has


class Names:
    """Which cell of which sheet every alias stands for. What a user types is column B; where that is a
    length, expressions use column G, which gives a plain number its millimetres."""

    WORD = re.compile(r"(?<![.\w])(?:(?:Params|Options|ToothParams)\.)?([A-Za-z_]\w*)")

    def __init__(self):
        self.cells = {}

    def add(self, sheet, alias, used):
        """`alias` belongs to `sheet`, whose cell `used` is the one to calculate with."""
        self.cells[alias] = (sheet.Name, used)

    def resolve(self, text, sheet=None):
        """`text` with the cells in place of aliases; those of `sheet` itself by their bare names."""
        def cell(word):
            if word.group(1) not in self.cells:
                return word.group(0)
            owner, used = self.cells[word.group(1)]
            return used if sheet is not None and sheet.Name == owner else owner + "." + used
        return self.WORD.sub(cell, text)


def build_parameters(document, design):
    """One spreadsheet per body, with hub, joint and options; `Params` with what driver and follower
    share; `ToothParams` with the section of the teeth. FreeCAD recomputes all that hangs on a sheet
    when one cell changes, so no cell of one gear may stand in the other's. Returns the `Names`."""
    names, group, rows = Names(), {}, {}
    for parameter in design["recipe"]["parameters"]:
        name = sheet_name(design, parameter)
        if name not in rows:
            new_sheet(document, name)
        sheet, row = document.getObject(name), rows.get(name, 2)
        if parameter["group"] != group.get(name):
            group[name] = parameter["group"]
            write_title(sheet, row, parameter["group"])
            row += 1
        write_parameter(sheet, row, parameter["name"], parameter["value"],
                        (parameter["min"], parameter["max"]), parameter["description"], names)
        rows[name] = row + 1
    sheet = new_sheet(document, TEETH)
    for row, (alias, words, warning) in enumerate(SECTION_ROWS, 2):
        value = design["section"]["rib" if alias == "rib_foot" else alias]
        limits = (0.0, value) if alias == "tip" else (0.0, 2.0 * value)
        write_parameter(sheet, row, alias, value, limits, words + "; " + warning, names)
    row = len(SECTION_ROWS) + 2
    for k, section in enumerate(tooth_sections(design), 1):
        row = write_flank(sheet, row, k, section, names)
    sheet.set("A%d" % (row + 1), "The curves of the teeth are the result of the "
              "search and do not change here: run mpcgear again for another motion.")
    document.recompute()
    return names


def sheet_name(design, parameter):
    """The sheet of a recipe's parameter: `Params` for what both gears use, else its body's."""
    users = [body["name"] for body in design["recipe"]["bodies"]
             if re.search(r"\b%s\b" % parameter["name"], str(body["features"]))]
    if parameter["group"] == "Fit" or {"driver", "follower"} <= set(users):
        return COMMON
    if parameter["group"] in ("Hub", "Joint") and "follower" in users:
        return "FollowerParams"
    if parameter["group"] == "Hub":
        return "DriverParams"
    return "SliderParams" if users == ["slider"] else "SupportParams"


def cell_of(document, alias):
    """(sheet, cell) where a user writes the parameter `alias`."""
    for sheet in document.findObjects("Spreadsheet::Sheet"):
        cell = sheet.getCellFromAlias(alias)
        if cell:
            return sheet, cell
    raise KeyError("no parameter is called " + alias)


def tooth_sections(design):
    """The section of the teeth of every sub-gear pair."""
    common = design["section"]
    radii = [pair.get("flank_radius", common["flank_radius"]) for pair in design["sub_gear_pairs"]]
    return [dict(common, flank_radius=radius) for radius in radii]


def edge_radius(section, height):
    """Radius of the edge between a flat flank and the end of the section `height` above or below the
    contact; 0 where the flank is no flatter than a round bead's."""
    radius, half = section["flank_radius"], (section["thickness"] - NARROWEST) / 2
    if radius <= max(section["thickness"] / 2, height):
        return 0.0
    rest = (height - FLANK * radius) / (1 - FLANK)
    widest = (half * (2 * radius - half) - height ** 2) / (2 * (radius - height))
    return min(max(min(max(rest, SHARPEST), widest), 0.0), height)


def write_flank(sheet, row, k, section, names):
    """Rows of the flanks of sub-gear pair `k`, and of the edges that follow from them; returns the
    next row."""
    radius, flattest = "flank_radius_%d" % k, section["flank_radius"]
    is_flat = flattest > section["thickness"] / 2
    words = "Radius of the flanks of sub-gear pair %d; BREAKS CONJUGATION when larger: flanks may meet " \
            "beside the contact; " % k
    words += "a smaller one keeps the contact but carries less" if is_flat else \
             "a round tip (tip = radius = thickness / 2) follows the thickness instead"
    least = 1.05 * max(section["thickness"] / 2, section["tip"]) if is_flat else 0.0
    write_parameter(sheet, row, radius, flattest, (min(least, flattest), flattest), words, names)
    for name, height, most in (("tip_edge", "tip", None), ("root_edge", "root", "(thickness - rib) / 2")):
        if edge_radius(section, section[height]) > 0.0:
            row += 1
            half = "(thickness - %s mm) / 2" % number(NARROWEST)
            rest = "({0} - {1} * {2}) / {3}".format(height, number(FLANK), radius, number(1 - FLANK))
            widest = "({0} * (2 * {1} - {0}) - {2} * {2}) / (2 * max({1} - {2}; 0.001 mm))".format(
                half, radius, height)
            formula = "max(min(max(%s; %s mm); %s; %s); 0.01 mm)" % (
                rest, number(SHARPEST), widest, most or height)
            write_formula(sheet, row, "%s_%d" % (name, k), formula,
                          "Radius of the edges between flank and %s" % height, names)
    return row + 1


def typed(document):
    """{alias: what stands in its cell} of everything that a user may change."""
    found = {}
    for sheet in document.findObjects("Spreadsheet::Sheet"):
        for row in range(2, LAST_ROW):
            alias = sheet.getAlias("B%d" % row)
            if alias and sheet.getContents("D%d" % row):  # what only follows has no largest value
                found[alias] = sheet.getContents("B%d" % row)
    return found


def kept(document, kind, name):
    """The object of that name of an earlier build, which others may stand on, or a new one."""
    found = [o for o in document.findObjects(kind) if o.TypeId == kind and o.Name.rstrip("0123456789") == name]
    return found[0] if found else document.addObject(kind, name)


def kept_sheet(document, name):
    """The same of a spreadsheet, empty."""
    sheet = kept(document, "Spreadsheet::Sheet", name)
    sheet.clearAll()
    return sheet


def new_sheet(document, name):
    """A spreadsheet with the head of a parameter table."""
    sheet = kept_sheet(document, name)
    titles = ["Parameter", "Value", "Min", "Max", "Check", "Meaning", "In use"]
    for column, title, width in zip("ABCDEFG", titles, [190, 80, 80, 80, 110, 520, 80]):
        sheet.set(column + "1", title)
        sheet.setColumnWidth(column, width)
    sheet.setStyle("A1:G1", "bold", "add")
    return sheet


def write_title(sheet, row, words):
    """The head of a group of parameters."""
    sheet.set("A%d" % row, words)
    sheet.setStyle("A%d" % row, "bold", "add")


def write_parameter(sheet, row, alias, value, limits, words, names, unit=" mm"):
    """One row: name, value, limits, a check that speaks up, meaning, and the value with its unit."""
    sheet.set("A%d" % row, alias)
    sheet.set("B%d" % row, "=" + number(value) + unit)
    sheet.setAlias("B%d" % row, alias)
    sheet.set("C%d" % row, "=" + number(limits[0]) + unit)
    sheet.set("D%d" % row, "=" + number(limits[1]) + unit)
    used = alias + "_mm" if unit else alias
    if unit:
        # str() alone tells 5 from 5 mm in every FreeCAD: == does so in 0.20 only.
        plain = "str(abs(0 * B{0})) == <<{1}>>"
        sheet.set("G%d" % row, ("=%s ? B{0} * 1 mm : (%s ? B{0} * 1 mm : B{0})" % (
            plain.format("{0}", "0"), plain.format("{0}", "0.0"))).format(row))
        sheet.setAlias("G%d" % row, used)
    names.add(sheet, alias, used)
    sheet.set("E%d" % row, "={1}{0} < C{0} ? <<TOO SMALL>> : ({1}{0} > D{0} ? <<TOO LARGE>> : <<ok>>)"
              .format(row, "G" if unit else "B"))
    sheet.set("F%d" % row, words)


def write_formula(sheet, row, alias, formula, words, names, least=None):
    """One row whose value follows from others, with a check if it must not fall below `least`."""
    sheet.set("A%d" % row, alias)
    sheet.set("B%d" % row, "=" + names.resolve(formula, sheet))
    sheet.setAlias("B%d" % row, alias)
    names.add(sheet, alias, alias)
    sheet.setStyle("A{0}:B{0}".format(row), "italic", "add")
    sheet.set("F%d" % row, words + ": follows from the rows above")
    if least is not None:
        sheet.set("C%d" % row, "=" + least)
        sheet.set("E%d" % row, "=B{0} < C{0} ? <<TOO SMALL>> : <<ok>>".format(row))


def number(value):
    """A number as FreeCAD's expressions read it back."""
    text = "%.9f" % value
    return text.rstrip("0").rstrip(".") if float(text) else "0"


class Expression:
    """A recipe expression as a FreeCAD expression: names become cells, and plain numbers that are
    added to lengths or stand alone get their millimetres."""

    OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}

    def __init__(self, names):
        self.names = names

    def length(self, text):
        """FreeCAD expression with the dimension of a length."""
        return self.coerce(self.convert(ast.parse(text.strip(), mode="eval").body, text), 1)[0]

    def coerce(self, term, power):
        """The (expression, power of mm) `term` brought to mm^`power`."""
        words, present = term
        for _ in range(abs(power - present)):
            words = "(%s) %s 1 mm" % (words, "*" if power > present else "/")
        return words, power

    def convert(self, node, text):
        """(FreeCAD expression, power of mm) of a syntax node."""
        if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
            return number(node.value), 0
        if isinstance(node, ast.Name) and node.id in self.names.cells:
            return self.names.resolve(node.id), 1
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
            words, power = self.convert(node.operand, text)
            return ("-(%s)" % words if isinstance(node.op, ast.USub) else words), power
        if isinstance(node, ast.BinOp) and type(node.op) in self.OPERATORS:
            left, right = self.convert(node.left, text), self.convert(node.right, text)
            sign = self.OPERATORS[type(node.op)]
            if sign in "+-":
                power = max(left[1], right[1])
                left, right = self.coerce(left, power), self.coerce(right, power)
            else:
                power = left[1] + right[1] if sign == "*" else left[1] - right[1]
            return "(%s %s %s)" % (left[0], sign, right[0]), power
        raise ValueError("expression '%s': only numbers, parameter names, + - * / and parentheses "
                         "are understood" % text)
