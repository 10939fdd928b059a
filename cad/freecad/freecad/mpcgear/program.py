"""The program `mpcgear`: where it is, and runs of it that a window can watch."""

import json
import os
import shutil
import signal
import subprocess
import sysconfig

import FreeCAD as App

VARIABLE = "MPCGEAR_BINARY"
NAME = "mpcgear.exe" if os.name == "nt" else "mpcgear"
INFEASIBLE, INTERRUPTED = 3, 130  # exit codes
translate = App.Qt.translate


class ProgramError(Exception):
    """The program is missing or has refused something; the text says what and what to do."""


def preferences():
    """FreeCAD's preferences of this add-on."""
    return App.ParamGet("User parameter:BaseApp/Preferences/Mod/mpcgear")


def find():
    """Path of the program: that of the preferences, of MPCGEAR_BINARY, on the PATH, or where pip and cargo
    put programs."""
    schemes = ["", "nt_user" if os.name == "nt" else "posix_user"]
    folders = [sysconfig.get_path("scripts", *([scheme] if scheme else [])) for scheme in schemes]
    folders.append(os.path.join(os.path.expanduser("~"), ".cargo", "bin"))
    named = [preferences().GetString("Program", ""), os.environ.get(VARIABLE, ""), shutil.which(NAME) or ""]
    for path in named + [os.path.join(folder, NAME) for folder in folders]:
        if path and os.path.isfile(path) and os.access(path, os.X_OK):
            return path
    raise ProgramError(translate(
        "mpcgear", "The program mpcgear is not found. Install it (pip install mpcgear), or give its path."))


class Run:
    """The program at work, its progress and its answer. Nothing here waits but `wait`."""

    def __init__(self, arguments, folder):
        self.paths = [os.path.join(folder, name) for name in ("answer.json", "progress.jsonl")]
        self.progress, self.read = {}, 0
        with open(self.paths[0], "wb") as out, open(self.paths[1], "wb") as err:
            own = {}
            if os.name == "nt":  # so that it can be told to stop, and shows no window of its own
                own["creationflags"] = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
            self.process = subprocess.Popen([find(), "--json"] + arguments, stdin=subprocess.DEVNULL,
                                            stdout=out, stderr=err, cwd=folder, **own)

    def is_running(self):
        """Whether it still works; reads what it has told of its progress since the last call."""
        running = self.process.poll() is None
        with open(self.paths[1], "rb") as told:
            told.seek(self.read)
            text = told.read()
        whole = text.rfind(b"\n") + 1
        self.read += whole
        for line in text[:whole].splitlines():
            record = parsed(line)
            if "stage" in record:
                self.progress = record
        return running

    def stop(self):
        """Asks it to end with the best that it has."""
        if self.process.poll() is None:
            self.process.send_signal(signal.CTRL_BREAK_EVENT if os.name == "nt" else signal.SIGINT)

    def kill(self):
        """Ends it at once."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def wait(self):
        """Waits for its end; returns its exit code."""
        return self.process.wait()

    def answer(self):
        """What it has written to standard output."""
        with open(self.paths[0], encoding="utf-8") as source:
            return source.read()

    def complaint(self):
        """Its error in words; empty when there is none."""
        with open(self.paths[1], encoding="utf-8", errors="replace") as source:
            lines = source.read().splitlines()
        records = [parsed(line) for line in lines]
        errors = [record["error"] for record in records if "error" in record]
        return errors[-1] if errors else "\n".join(
            line for line, record in zip(lines, records) if not record)


def ask(arguments, folder):
    """What a short run answers. Raises ProgramError with its words when it fails."""
    run = Run(arguments, folder)
    if run.wait() != 0:
        raise ProgramError(run.complaint())
    return run.answer()


def parsed(line):
    """The JSON object in a line; an empty one when it holds none."""
    try:
        record = json.loads(line)
    except ValueError:
        return {}
    return record if isinstance(record, dict) else {}
