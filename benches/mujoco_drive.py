#!/usr/bin/env python3
"""Turns the motor of a MuJoCo model once and tells how far the follower leaves the motion asked for.

    mpcgear export out/trefoil --to mjcf -o model
    python3 -m pip install mujoco
    python3 benches/mujoco_drive.py model/Trefoil.xml [--seconds 2] [--payload 0.8] [--without 1]

The follower is compared with the target at the angle that the driver has, so that what the motor
lags behind does not count. `--without` takes the teeth of one sub-gear pair away: what it was for.
"""

import argparse
import math

import mujoco
import numpy as np

START = 0.2  # s in which the motor gets to speed


def asked(time, speed):
    """Angle of the motor at a time, s, when it starts evenly."""
    if time < START:
        return 0.5 * speed * time * time / START
    return speed * (time - 0.5 * START)


def target(model):
    """The follower's poses over one turn: x, y, z in m, qw, qx, qy, qz."""
    return model.numeric("target").data.reshape(-1, 7)


def deviation(rows, angle, position, rotation):
    """Distance (m) and turn (rad) from the pose asked for at an angle of the driver."""
    at = (angle / (2 * math.pi)) % 1.0 * (len(rows) - 1)
    i = min(int(at), len(rows) - 2)
    row = rows[i] + (at - i) * (rows[i + 1] - rows[i])
    wanted = row[3:] / np.linalg.norm(row[3:])
    turn = np.zeros(4)
    mujoco.mju_mulQuat(turn, wanted * [1, -1, -1, -1], rotation)
    return np.linalg.norm(position - row[:3]), 2 * math.atan2(np.linalg.norm(turn[1:]), abs(turn[0]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("model")
    parser.add_argument("--seconds", type=float, default=2.0, help="time of one turn")
    parser.add_argument("--payload", type=float, help="kg; that of the model by default")
    parser.add_argument("--without", type=int, help="sub-gear pair to leave out, from 1")
    given = parser.parse_args()
    spec = mujoco.MjSpec.from_file(given.model)
    for geom in spec.geoms:
        if given.without is not None and geom.name.startswith(f"driver_{given.without}_"):
            geom.contype = geom.conaffinity = 0
        if given.payload is not None and geom.name == "payload":
            geom.mass = given.payload
    model = spec.compile()
    data = mujoco.MjData(model)
    rows = target(model)
    speed = 2 * math.pi / given.seconds
    farthest = widest = (0.0, 0.0)
    lost, torque = None, 0.0
    print(f"{model.ngeom} geoms, timestep {model.opt.timestep:g} s, {given.seconds:g} s per turn")
    sensor = lambda name: data.sensor(name).data
    while (angle := sensor("driver_angle")[0]) < 2 * math.pi:
        if data.time > 3 * given.seconds + 1:
            print(f"jams at {math.degrees(angle):.1f} deg")
            break
        data.ctrl[0] = asked(data.time, speed)
        mujoco.mj_step(model, data)
        if not np.isfinite(data.qpos).all() or data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            print(f"unstable at {math.degrees(angle):.1f} deg")
            break
        mujoco.mj_sensorPos(model, data)
        here = sensor("driver_angle")[0]
        away, turn = deviation(rows, here, sensor("follower_position"), sensor("follower_rotation"))
        widest = max(widest, (turn, here))
        farthest = max(farthest, (away, here))
        torque = max(torque, abs(sensor("motor_torque")[0]))
        if lost is None and turn > math.radians(10):
            lost = here
    print(f"largest turn away {math.degrees(widest[0]):.3f} deg at {math.degrees(widest[1]):.1f} deg of the driver")
    print(f"largest distance away {1e3 * farthest[0]:.4f} mm at {math.degrees(farthest[1]):.1f} deg")
    print(f"largest motor torque {1e3 * torque:.1f} N mm")
    print("motion kept" if lost is None else f"motion lost at {math.degrees(lost):.1f} deg")


if __name__ == "__main__":
    main()
