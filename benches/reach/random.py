"""Random smooth motions: python3 random.py CLASS LEVEL FIRST COUNT FOLDER writes COUNT motion files.

Own turn (1R, 1R1T): harmonics 1 to 3 of the angle, largest change of speed LEVEL x 20 %. Axis (3R, 3R1T):
harmonics 1 to 3 in x and y, largest tilt LEVEL x 8 degrees. Slide (1R1T, 3R1T): harmonics 1 and 2, largest
LEVEL x 1.3 mm. Amplitudes are normal, divided by the harmonic. Motion number N of a class has the same shape at
every level.
"""

import math
import random
import sys

PHASES = [i * math.tau / 720 for i in range(720)]


def series(rng, harmonics):
    return [(k, rng.gauss(0, 1) / k, rng.gauss(0, 1) / k) for k in harmonics]


def value(terms, phi):
    return sum(a * math.sin(k * phi) + b * math.cos(k * phi) for k, a, b in terms)


def rate(terms, phi):
    return sum(k * (a * math.cos(k * phi) - b * math.sin(k * phi)) for k, a, b in terms)


def text(terms, scale):
    return " ".join(
        f"{scale * x:+.6f}*{name}({k}*phi)" for k, a, b in terms for x, name in ((a, "sin"), (b, "cos"))
    )


def motion(joint, level, number):
    # Texts as seeds are hashed the same way by every Python.
    rng = random.Random(f"{joint} {number}")
    name = f"random_{joint.lower()}_{level:g}_{number}"
    lines = [f'name = "{name}"', f'class = "{joint}"', "", "[motion]", 'kind = "formula"']
    if joint in ("1R", "1R1T"):
        turn = series(rng, (1, 2, 3))
        most = max(abs(rate(turn, phi)) for phi in PHASES)
        lines.append(f'own_turn = "-phi {text(turn, 0.2 * level / most)}"')
    else:
        lines.append('own_turn = "-phi"')
        x, y = series(rng, (1, 2, 3)), series(rng, (1, 2, 3))
        most = max(math.hypot(value(x, phi), value(y, phi)) for phi in PHASES)
        scale = math.tan(math.radians(8 * level)) / most
        lines.append(f'axis = ["{text(x, scale)}", "{text(y, scale)}", "1"]')
    if joint in ("1R1T", "3R1T"):
        slide = series(rng, (1, 2))
        most = max(abs(value(slide, phi)) for phi in PHASES)
        lines.append(f'translation = ["0", "0", "{text(slide, 1.3 * level / most)}"]')
    return name, "\n".join(lines) + "\n"


if __name__ == "__main__":
    joint, level, first, count, folder = sys.argv[1:]
    for number in range(int(first), int(first) + int(count)):
        name, body = motion(joint, float(level), number)
        with open(f"{folder}/{name}.toml", "w", encoding="utf-8") as file:
            file.write(body)
