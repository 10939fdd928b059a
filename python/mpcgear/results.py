"""Designs as the program leaves them on disk, as arrays."""

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpcgear import program

BODIES = ("driver", "follower", "support", "slider")
"""Rigid bodies of a mechanism; only 3R1T has a slider."""

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84


@dataclass(frozen=True)
class Mesh:
    """A closed surface, assembled at φ = 0, mm."""

    triangles: NDArray[np.float64]
    """Corners, triangle by corner by coordinate."""

    @classmethod
    def read(cls, path: Path) -> "Mesh":
        """Reads a binary STL file. Raises ValueError where it is none."""
        data = path.read_bytes()
        count = int.from_bytes(data[_HEADER - 4 : _HEADER], "little")
        if len(data) != _HEADER + count * _TRIANGLE.itemsize:
            raise ValueError(f"{path} is not a binary STL file")
        records = np.frombuffer(data, _TRIANGLE, offset=_HEADER)
        return cls(records["corners"].astype(np.float64))

    @property
    def volume_mm3(self) -> float:
        """Volume inside the surface, mm³."""
        a, b, c = (self.triangles[:, i] for i in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and largest corner of the box around it, mm."""
        points = self.triangles.reshape(-1, 3)
        return points.min(axis=0), points.max(axis=0)


@dataclass(frozen=True)
class Design:
    """A design in its output folder."""

    folder: Path

    @property
    def summary(self) -> dict[str, Any]:
        """The figures of `summary.json`."""
        loaded: dict[str, Any] = json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))
        return loaded

    @property
    def works(self) -> bool:
        """Whether it was proved to work."""
        return bool(self.summary["feasible"])

    @property
    def meshes(self) -> dict[str, Mesh]:
        """The rigid bodies by name; empty where they could not be built."""
        files = {name: self.folder / "meshes" / f"{name}.stl" for name in BODIES}
        return {name: Mesh.read(path) for name, path in files.items() if path.is_file()}

    @property
    def poses(self) -> NDArray[np.float64]:
        """Pose of the follower, a row per degree: φ (deg), x, y, z (mm), qw, qx, qy, qz."""
        with (self.folder / "poses.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))[1:]
        return np.array(rows, dtype=np.float64)

    def load(self, payload_g: float | None = None) -> dict[str, Any]:
        """What `mpcgear load` says: forces, torque, payload, play, sensitivity."""
        more = [] if payload_g is None else ["--payload", f"{payload_g}g"]
        answer: dict[str, Any] = program.run(["load", *more, "--", str(self.folder)])
        return answer


def design(
    motion: str | Path,
    out: str | Path,
    *,
    draft: bool = False,
    seed: int | None = None,
    changes: Mapping[str, float | int | str | bool] | None = None,
) -> Design:
    """Designs the motion file `motion` into the folder `out`.

    `draft` is a first look of a few seconds; `changes` sets fields of the motion file: {"gear.teeth": 12}.
    Raises BadInput for files and values that are wrong, Infeasible where no gear came out.
    """
    arguments = ["design", "--out", str(out)]
    if draft:
        arguments.append("--draft")
    if seed is not None:
        arguments += ["--seed", str(seed)]
    for path, value in (changes or {}).items():
        arguments += ["--set", f"{path}={json.dumps(value)}"]
    program.run([*arguments, "--", str(motion)])
    return Design(Path(out))
