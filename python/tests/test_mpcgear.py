"""Designing from Python, with the program itself."""

from pathlib import Path

import numpy as np
import pytest

import mpcgear

MOTION = """
class = "1R"
[motion]
kind = "formula"
own_turn = "-phi + 0.1*sin(phi)"
[search]
effort = 0.05
"""


@pytest.fixture
def motion(tmp_path: Path) -> Path:
    path = tmp_path / "my.toml"
    path.write_text(MOTION, encoding="utf-8")
    return path


def test_a_draft_has_meshes_poses_and_figures(motion: Path, tmp_path: Path) -> None:
    made = mpcgear.design(motion, tmp_path / "out", draft=True, changes={"gear.teeth": 12})
    assert made.summary["j"] == 12 and not made.works
    assert set(made.meshes) == {"driver", "follower", "support"}
    for mesh in made.meshes.values():
        low, high = mesh.bounds
        assert 0 < mesh.volume_mm3 < np.prod(high - low)
    poses = made.poses
    assert poses.shape == (361, 8) and poses[-1, 0] == 360
    turn = -np.radians(poses[:, 0]) + 0.1 * np.sin(np.radians(poses[:, 0]))
    assert np.allclose(np.abs(poses[:, 4]), np.abs(np.cos(turn / 2)), atol=1e-8)
    assert made.load(payload_g=200)["force_max"] >= 0


def test_errors_are_those_of_the_program(motion: Path, tmp_path: Path) -> None:
    with pytest.raises(mpcgear.BadInput, match="allowed 3 to 60"):
        mpcgear.design(motion, tmp_path / "out", changes={"gear.teeth": 2})
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_no_mesh_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.stl"
    path.write_bytes(b"solid nothing")
    with pytest.raises(ValueError, match="not a binary STL"):
        mpcgear.Mesh.read(path)
