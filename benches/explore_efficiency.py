"""How well two workers are used: the same drafts with one worker and with two, one thread each.

    python3 benches/explore_efficiency.py target/release/mpcgear [trials]

Prints drafts per second of both and the share of twice the first that the second reaches; also the share of the
workers' time in which a trial was under way (`busy`), which other programs on the machine cannot spoil, and in which it
had a processor (`cpu`): what `cpu` lacks of `busy` went to other programs. Trials are drawn at
random with one seed, so both runs compute the same. Needs the packages of the extra `explore`.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "python"))

STUDY = """
sampler = "random"
[variables]
"gear.center_distance_mm" = { low = 24.0, high = 30.0 }
"fit.clearance_mm" = { low = 0.08, high = 0.12 }
[objectives]
plastic_g = "down"
play_mm = "down"
[budget]
trials = @@
keep = 0
"""


def timed(binary: Path, folder: Path, workers: int, trials: int) -> tuple[float, float, float]:
    """Seconds of the drafts from first question to last answer; of all trials together seconds and processor time."""
    from mpcgear_explore import storage
    from mpcgear_explore.study import Study

    (folder / "study.toml").write_text(STUDY.replace("@@", str(trials)), encoding="utf-8")
    motion = ROOT / "examples" / "trefoil.toml"
    out = folder / f"study{workers}"
    command = [str(binary), "--json", "explore", str(motion), str(folder / "study.toml"), "-o", str(out)]
    subprocess.run([*command, "--workers", str(workers)], check=True, stdout=subprocess.DEVNULL)
    opened = storage.open_rung(Study.read(out), 0)
    told = storage.results(opened)
    starts = [t.datetime_start for t, _ in told if t.datetime_start]
    ends = [t.datetime_complete for t, _ in told if t.datetime_complete]
    records = [r for _, r in told if r]
    spent = sum(r.cpu_seconds or 0.0 for r in records)
    return (max(ends) - min(starts)).total_seconds(), sum(r.seconds for r in records), spent


def main() -> None:
    """Runs both and prints the table."""
    binary = Path(sys.argv[1]).resolve()
    trials = int(sys.argv[2]) if len(sys.argv) > 2 else 40
    rates = {}
    with tempfile.TemporaryDirectory() as name:
        for workers in (1, 2):
            started = time.monotonic()
            seconds, busy, spent = timed(binary, Path(name), workers, trials)
            rates[workers] = trials / seconds
            print(
                json.dumps(
                    {
                        "workers": workers,
                        "drafts_per_s": round(rates[workers], 3),
                        "busy_percent": round(100 * busy / (workers * seconds), 1),
                        "cpu_percent": round(100 * spent / (workers * seconds), 1),
                        "cpu_s_per_draft": round(spent / trials, 3),
                        "whole_run_s": round(time.monotonic() - started, 1),
                    }
                )
            )
    print(json.dumps({"efficiency_percent": round(100 * rates[2] / (2 * rates[1]), 1)}))


if __name__ == "__main__":
    main()
