#!/usr/bin/env python3
"""The same profiles fitted by hemline and by what a laboratory would use instead, on one thread, in one run: ratios of CPU time.

usage: scripts/fit_beside_peers.py PATH/TO/peers/bench_fits.py [--rounds 3]

bench_fits.py (scipy.odr, odrpack, scipy's least_squares with foot points, Ceres) is called with this Python; install its requirements.txt first.
hemline's side is `cargo bench --bench fit`. The rounds alternate, and medians are printed: m given in all rows but the last two.
"""
import argparse
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def peers(script, profiles):
    out = subprocess.run([sys.executable, script, profiles, "--runs", "3"], check=True, capture_output=True, text=True).stdout
    rows = re.findall(r"^(.+?)\s+wall\s+[\d.]+ cpu\s+([\d.]+) ms/profile\s+SS ([\d.]+)", out, re.M)
    return {name: (float(cpu), float(square)) for name, cpu, square in rows}


def hemline(profiles):
    command = ["cargo", "bench", "--quiet", "--bench", "fit", "--", profiles]
    out = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    rows = re.findall(r"^(.+?)\s+([\d.]+) ms/profile\s+([\d.]+) evaluations\s+SS ([\d.]+)", out, re.M)
    return {"hemline, " + name: (float(cpu), float(square)) for name, cpu, _, square in rows}


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("bench_fits")
    arguments.add_argument("--rounds", type=int, default=3)
    asked = arguments.parse_args()
    script = str(Path(asked.bench_fits).resolve())
    times, squares = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        profiles = str(Path(folder) / "profiles.csv")
        subprocess.run([sys.executable, script, "--write", profiles, "--runs", "1"], check=True, capture_output=True)
        hemline(profiles)
        for _ in range(asked.rounds):
            for name, (cpu, square) in {**peers(script, profiles), **hemline(profiles)}.items():
                times.setdefault(name, []).append(cpu)
                squares[name] = square
    medians = {name: statistics.median(values) for name, values in times.items()}
    own = next(value for name, value in medians.items() if name.startswith("hemline, m given"))
    print("| solver | CPU ms a profile | times hemline's | sum of squares, cm² |\n|---|---|---|---|")
    for name, value in medians.items():
        print(f"| {name} | {value:.3f} | {value / own:.1f} | {squares[name]:.8f} |")


if __name__ == "__main__":
    main()
