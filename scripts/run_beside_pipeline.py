#!/usr/bin/env python3
"""Seconds and peak memory of `hemline run` beside the script that a laboratory would write instead, on the same campaign, in turn.

usage: run_beside_pipeline.py PIPELINE.py [CAMPAIGN] [--hemline PROGRAM] [--turns N]

PIPELINE.py CAMPAIGN OUT.pdf is the other script. Every turn runs both, one after the other; the least of the turns is printed.
"""
import argparse, os, subprocess, sys, tempfile, time


def measured(command):
    """Seconds by the clock, seconds of processors, peak of resident memory in MB."""
    began = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    # Runs that a campaign could not fit end with 1.
    if os.waitstatus_to_exitcode(status) not in (0, 1):
        sys.exit(f"{' '.join(command)} failed")
    return time.perf_counter() - began, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pipeline")
    parser.add_argument("campaign", nargs="?", default="data")
    parser.add_argument("--hemline", default=os.path.join(os.environ.get("CARGO_TARGET_DIR", "target"), "release", "hemline"))
    parser.add_argument("--turns", type=int, default=3)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        commands = {
            "hemline run": [asked.hemline, "run", asked.campaign, "--out", os.path.join(folder, "report")],
            os.path.basename(asked.pipeline): [sys.executable, asked.pipeline, asked.campaign, os.path.join(folder, "other.pdf")],
        }
        turns = [{name: measured(command) for name, command in commands.items()} for _ in range(asked.turns)]
    best = {name: [min(turn[name][k] for turn in turns) for k in range(3)] for name in commands}
    print(f"{'':16} {'by the clock, s':>16} {'of processors, s':>17} {'peak memory, MB':>16}")
    for name, (clock, processors, memory) in best.items():
        print(f"{name:16} {clock:16.2f} {processors:17.2f} {memory:16.0f}")
    ours, theirs = best.values()
    print(f"{'ratio':16} {theirs[0] / ours[0]:16.1f} {theirs[1] / ours[1]:17.1f} {theirs[2] / ours[2]:16.2f}")


main()
