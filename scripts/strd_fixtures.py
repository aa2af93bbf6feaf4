#!/usr/bin/env python3
"""Transcribes NIST StRD data and certified values into tests/fixtures/strd.json and strd_nonlinear.json.

Usage: scripts/strd_fixtures.py FOLDER   (FOLDER holds linear/*.dat, anova/*.dat and nonlinear/*.dat from https://www.itl.nist.gov/div898/strd/)
Python 3.9 or later, standard library only. The numbers are facts published by NIST (public domain); they are kept as the decimal strings of
the source so that no digit is lost. The nine SmLs sets follow one rule (Simon & Lesage 1989); the rule is stored after checking every value.
"""
import json
import re
import sys
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

folder = Path(sys.argv[1])
out = Path(__file__).resolve().parent.parent / "tests" / "fixtures" / "strd.json"
NUMBER = r"[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?"


def span(text, what):
    first, last = re.search(what + r"\s*\(lines\s+(\d+)\s+to\s+(\d+)\)", text).groups()
    return int(first) - 1, int(last)


def linear(path):
    text = path.read_text()
    lines = text.splitlines()
    a, b = span(text, "Certified Values")
    certified = "\n".join(lines[a : b + 12])
    coefficients = [list(m) for m in re.findall(rf"^\s+B\d+\s+({NUMBER})\s+({NUMBER})\s*$", certified, re.M)]
    a, b = span(text, "Data")
    rows = [line.split() for line in lines[a:b]]
    regression = re.search(rf"Regression\s+(\d+)\s+({NUMBER})\s+({NUMBER})\s+({NUMBER}|Infinity)", text).groups()
    return {
        "name": path.stem,
        "polynomial": path.stem not in ("Longley", "NoInt1", "NoInt2", "Norris"),
        "intercept": not path.stem.startswith("NoInt"),
        "coefficients": coefficients,
        "residual_standard_deviation": re.search(rf"Residual\s+Standard Deviation\s+({NUMBER})", text).group(1),
        "r_squared": re.search(rf"R-Squared\s+({NUMBER})", text).group(1),
        "regression_sum_of_squares": regression[1],
        "f": None if regression[3] == "Infinity" else regression[3],
        "y": [row[0] for row in rows],
        "x": [[row[j] for row in rows] for j in range(1, len(rows[0]))],
    }


def anova(path):
    text = path.read_text()
    lines = text.splitlines()
    a, b = span(text, "Data")
    groups = {}
    for line in lines[a:b]:
        treatment, value = line.split()
        groups.setdefault(int(treatment), []).append(value)
    between = re.search(rf"Between \w+\s+(\d+)\s+({NUMBER})\s+({NUMBER})\s+({NUMBER})", text).groups()
    within = re.search(rf"Within \w+\s+(\d+)\s+({NUMBER})\s+({NUMBER})", text).groups()
    # What the doubles nearest to the published decimals hold, in exact rational arithmetic: nobody who reads doubles can come nearer.
    exact = [[Fraction(float(value)) for value in group] for group in groups.values()]
    grand = sum(map(sum, exact)) / sum(map(len, exact))
    means = [sum(group) / len(group) for group in exact]
    rounded_between = sum(len(group) * (mean - grand) ** 2 for group, mean in zip(exact, means))
    rounded_within = sum((value - mean) ** 2 for group, mean in zip(exact, means) for value in group)
    data = {"groups": list(groups.values())}
    if path.stem.startswith("SmLs"):
        offset = int(Decimal(groups[1][0]))
        first = [Decimal(g[0]) - offset for g in groups.values()]
        for start, group in zip(first, groups.values()):
            step = Decimal("0.1")
            for i, value in enumerate(group):
                want = start if i == 0 else start + (step if i % 2 == 0 else -step)
                assert Decimal(value) - offset == want, (path.stem, i, value)
        data = {"offset": str(offset), "levels": [str(f) for f in first], "replicates": len(groups[1])}
    return {
        "name": path.stem,
        **data,
        "between_df": between[0],
        "between_sum_of_squares": between[1],
        "f": between[3],
        "within_df": within[0],
        "within_sum_of_squares": within[1],
        "rounded": [float(rounded_between), float(rounded_within)],
        "r_squared": re.search(rf"Certified R-Squared\s+({NUMBER})", text).group(1),
        "residual_standard_deviation": re.search(rf"Certified Residual\s+Standard Deviation\s+({NUMBER})", text).group(1),
    }


def nonlinear(path):
    text = path.read_text()
    lines = text.splitlines()
    a, b = span(text, "Certified Values")
    certified = "\n".join(lines[a : b + 12])
    row = rf"^\s*b\d+\s*=\s+({NUMBER})\s+({NUMBER})\s+({NUMBER})\s+({NUMBER})\s*$"
    parameters = re.findall(row, certified, re.M)
    a, b = span(text, "Data")
    rows = [line.split() for line in lines[a:b] if line.strip()]
    return {
        "name": path.stem,
        "starts": [[p[0] for p in parameters], [p[1] for p in parameters]],
        "parameters": [p[2] for p in parameters],
        "standard_deviations": [p[3] for p in parameters],
        "sum_of_squares": re.search(rf"Residual Sum of Squares:\s+({NUMBER})", text).group(1),
        "residual_standard_deviation": re.search(rf"Residual Standard Deviation:\s+({NUMBER})", text).group(1),
        "degrees_of_freedom": int(re.search(r"Degrees of Freedom:\s+(\d+)", text).group(1)),
        "y": [row[0] for row in rows],
        "x": [row[1:] for row in rows],
    }


fixture = {
    "source": "NIST Statistical Reference Datasets, https://www.itl.nist.gov/div898/strd/ (public domain)",
    "linear": [linear(p) for p in sorted((folder / "linear").glob("*.dat"))],
    "anova": [anova(p) for p in sorted((folder / "anova").glob("*.dat"))],
}
# One line per data set keeps the file readable in a diff.
sets = {key: "[\n" + ",\n".join(json.dumps(item) for item in fixture[key]) + "\n]" for key in ("linear", "anova")}
out.parent.mkdir(parents=True, exist_ok=True)
out.write_text(f'{{"source": {json.dumps(fixture["source"])},\n"linear": {sets["linear"]},\n"anova": {sets["anova"]}}}\n')
beside = out.with_name("strd_nonlinear.json")
sets = [nonlinear(p) for p in sorted((folder / "nonlinear").glob("*.dat"))]
rows = ",\n".join(json.dumps(item) for item in sets)
beside.write_text(f'{{"source": {json.dumps(fixture["source"])},\n"nonlinear": [\n{rows}\n]}}\n')
print(beside, beside.stat().st_size, "bytes")
print(out, out.stat().st_size, "bytes")
