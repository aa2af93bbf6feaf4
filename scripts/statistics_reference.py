#!/usr/bin/env python3
"""Reference numbers for the statistics, from statsmodels, SciPy and mpmath, into tests/fixtures/statistics_reference.json.

Usage: python3 -m venv venv && venv/bin/pip install numpy scipy pandas statsmodels mpmath && venv/bin/python scripts/statistics_reference.py
Versions are written into the fixture. Random designs come from numpy's PCG64 with fixed seeds; every float is written with 17 digits.
"""
import itertools
import json
import re
from pathlib import Path

import mpmath as mp
import numpy as np
import pandas as pd
import scipy
import statsmodels
import statsmodels.api as sm
from scipy import stats
from statsmodels.formula.api import ols
from statsmodels.stats.anova import anova_lm
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.stattools import durbin_watson

OUT = Path(__file__).resolve().parent.parent / "tests" / "fixtures" / "statistics_reference.json"
LETTERS = "abcdef"


def terms(k):
    return [c for size in range(k + 1) for c in itertools.combinations(range(k), size)]


def name(term):
    return ":".join(LETTERS[i] for i in term) if term else "1"


def factorial(k, replicates, seed, offset=10.0, drop=0):
    """A 2^k design in random order with `replicates` runs per cell, `drop` of them removed; coefficients of random size."""
    rng = np.random.Generator(np.random.PCG64(seed))
    corners = np.array([[1.0 if run >> i & 1 else -1.0 for i in range(k)] for run in range(2**k)])
    levels = np.repeat(corners, replicates, axis=0)
    levels = levels[rng.permutation(len(levels))]
    if drop:
        levels = levels[np.sort(rng.choice(len(levels), len(levels) - drop, replace=False))]
    X = np.column_stack([np.prod(levels[:, list(t)], axis=1) if t else np.ones(len(levels)) for t in terms(k)])
    b = rng.normal(size=X.shape[1]) * (rng.random(X.shape[1]) < 0.6)
    b[0] = offset
    y = X @ b + rng.normal(size=len(levels)) * 0.5
    return levels, X, y


def design_case(label, k, replicates, seed, **kw):
    levels, X, y = factorial(k, replicates, seed, **kw)
    model = sm.OLS(y, X).fit()
    influence = model.get_influence()
    ci = model.conf_int(0.05)
    cells = {}
    for row, value in zip(levels, y):
        cells.setdefault(tuple(row), []).append(value)
    significant = [j for j in range(X.shape[1]) if model.pvalues[j] < 0.05]
    reduced = sm.OLS(y, X[:, significant]).fit()
    case = {
        "label": label,
        "levels": levels.tolist(),
        "y": y.tolist(),
        "terms": [name(t) for t in terms(k)],
        "estimate": model.params.tolist(),
        "se": model.bse.tolist(),
        "t": model.tvalues.tolist(),
        "p": model.pvalues.tolist(),
        "ci": ci.tolist(),
        "residual_df": model.df_resid,
        "r_squared": model.rsquared,
        "adjusted_r_squared": model.rsquared_adj,
        "f": model.fvalue,
        "leverage": influence.hat_matrix_diag.tolist(),
        "standardized": influence.resid_studentized_internal.tolist(),
        "deleted": influence.resid_studentized_external.tolist(),
        "cook": influence.cooks_distance[0].tolist(),
        "press": float(np.sum(influence.resid_press**2)),
        "durbin_watson": float(durbin_watson(model.resid)),
        "shapiro_w": float(stats.shapiro(model.resid).statistic),
        "shapiro_p": float(stats.shapiro(model.resid).pvalue),
        "holm": multipletests(model.pvalues, method="holm")[1].tolist(),
        "benjamini_hochberg": multipletests(model.pvalues, method="fdr_bh")[1].tolist(),
        "significant": [name(terms(k)[j]) for j in significant],
    }
    pure_df = len(y) - len(cells)
    if len(cells) > len(significant) and len(cells) == 2**k:
        # Lack of fit as the F test between the reduced and the saturated model.
        f, p, df = model.compare_f_test(reduced)
        case["adequacy"] = {"f": float(f), "p": float(p), "df": [float(df), float(pure_df)]}
    sizes = {len(v) for v in cells.values()}
    if sizes == {1}:
        pass
    elif len(sizes) == 1:
        variances = [np.var(v, ddof=1) for v in cells.values()]
        case["cochran"] = float(max(variances) / sum(variances))
    else:
        w, p = stats.levene(*[v for v in cells.values() if len(v) > 1], center="median")
        case["brown_forsythe"] = [float(w), float(p)]
    return case


def weighted_case(seed):
    rng = np.random.Generator(np.random.PCG64(seed))
    X = np.column_stack([np.ones(30), rng.normal(size=(30, 3))])
    w = rng.uniform(0.2, 5.0, 30)
    y = X @ [3.0, -1.0, 0.5, 0.0] + rng.normal(size=30) / np.sqrt(w)
    model = sm.WLS(y, X, weights=w).fit()
    return {
        "x": X[:, 1:].T.tolist(), "y": y.tolist(), "weights": w.tolist(),
        "estimate": model.params.tolist(), "se": model.bse.tolist(), "p": model.pvalues.tolist(),
        "r_squared": model.rsquared, "residual_sum_of_squares": model.ssr,
        # Errors known instead of estimated: s² = 1.
        "known_se": np.sqrt(np.diag(model.normalized_cov_params)).tolist(),
        "known_p": [float(2 * stats.norm.sf(abs(b) / s)) for b, s in zip(model.params, np.sqrt(np.diag(model.normalized_cov_params)))],
    }


def anova_case(seed, drop):
    levels, _, y = factorial(3, 3, seed, drop=drop)
    frame = pd.DataFrame(levels, columns=list("abc")).assign(y=y)
    # Sum-to-zero coding of categories: the levels themselves up to sign, and the terms in the order of their degree (numeric columns would
    # be ordered otherwise, which type I feels).
    model = ols("y ~ C(a, Sum) * C(b, Sum) * C(c, Sum)", frame).fit()
    sources = ["a", "b", "c", "a:b", "a:c", "b:c", "a:b:c"]
    case = {"levels": levels.tolist(), "y": y.tolist(), "sources": sources}
    for typ in (1, 2, 3):
        table = anova_lm(model, typ=typ)
        table.index = [re.sub(r"C\((\w), Sum\)", r"\1", row) for row in table.index]
        case[f"type{typ}"] = [[float(table.loc[s, "sum_sq"]), float(table.loc[s, "F"]), float(table.loc[s, "PR(>F)"])] for s in sources]
    return case


def box_cox_case(seed):
    levels, X, y = factorial(2, 4, seed, offset=3.0)
    y = np.exp(0.4 * y)
    n = len(y)

    def profile(lam):
        g = np.exp(np.mean(np.log(y)))
        z = g * np.log(y) if lam == 0 else (y**lam - 1) / (lam * g ** (lam - 1))
        return -n / 2 * np.log(sm.OLS(z, X).fit().ssr / n)

    best = scipy.optimize.minimize_scalar(lambda l: -profile(l), bounds=(-3, 3), method="bounded", options={"xatol": 1e-12})
    target = profile(best.x) - stats.chi2.ppf(0.95, 1) / 2
    low = scipy.optimize.brentq(lambda l: profile(l) - target, best.x - 3, best.x, xtol=1e-13)
    high = scipy.optimize.brentq(lambda l: profile(l) - target, best.x, best.x + 3, xtol=1e-13)
    return {"levels": levels.tolist(), "y": y.tolist(), "lambda": float(best.x), "low": float(low), "high": float(high)}


def tails():
    """Tails of t, F, χ² and the normal law at 50 digits, far out and with large degrees of freedom."""
    mp.mp.dps = 50
    out = {"student": [], "fisher": [], "chi_squared": [], "normal": []}
    for df in (1, 2, 3, 5, 10, 32, 100, 1000, 10000, 100000):
        for t in ("0.001", "0.5", "1", "2", "5", "10", "40", "1000"):
            t_ = mp.mpf(float(t))
            p = mp.betainc(mp.mpf(df) / 2, mp.mpf("0.5"), 0, df / (df + t_**2), regularized=True)
            if p > mp.mpf("1e-290"):
                out["student"].append([float(t), df, float(p)])
    for d1, d2 in ((1, 1), (1, 32), (2, 5), (4, 28), (7, 32), (6, 1000), (63, 256), (256, 63), (1000, 1000)):
        for f in ("0.01", "0.5", "1", "2", "5", "30", "300"):
            f_ = mp.mpf(float(f))
            p = mp.betainc(mp.mpf(d2) / 2, mp.mpf(d1) / 2, 0, d2 / (d2 + d1 * f_), regularized=True)
            if p > mp.mpf("1e-290"):
                out["fisher"].append([float(f), d1, d2, float(p)])
    for df in (1, 2, 5, 32, 200):
        for x in ("0.01", "1", "5", "30", "100", "400"):
            p = mp.gammainc(mp.mpf(df) / 2, mp.mpf(float(x)) / 2, mp.inf, regularized=True)
            if p > mp.mpf("1e-290"):
                out["chi_squared"].append([float(x), df, float(p)])
    for z in ("-3", "0", "0.5", "1", "1.96", "3", "5", "8", "15", "30", "37"):
        out["normal"].append([float(z), float(mp.erfc(mp.mpf(float(z)) / mp.sqrt(2)) / 2)])
    return out


def shapiro_cases():
    rng = np.random.Generator(np.random.PCG64(77))
    cases = []
    for n, kind in ((3, "n"), (4, "n"), (7, "e"), (11, "n"), (12, "e"), (40, "n"), (40, "e"), (200, "n"), (1000, "e")):
        x = rng.normal(size=n) if kind == "n" else rng.exponential(size=n)
        r = stats.shapiro(x)
        cases.append({"x": x.tolist(), "w": float(r.statistic), "p": float(r.pvalue)})
    return cases


def power_cases():
    """Power of the two-sided t test of one coefficient: 1 minus the integral of the normal law over the chi law of the error estimate."""
    mp.mp.dps = 30
    cases = []
    for df, ncp in ((32, 1.0), (32, 3.351), (8, 4.0), (4, 6.0), (100, 2.5), (2, 20.0), (32, 10.0)):
        t = mp.findroot(lambda x: mp.betainc(mp.mpf(df) / 2, mp.mpf("0.5"), 0, df / (df + x**2), regularized=True) - mp.mpf("0.05"), float(stats.t.ppf(0.975, df)))
        density = lambda s: 2 * (mp.mpf(df) / 2) ** (mp.mpf(df) / 2) / mp.gamma(mp.mpf(df) / 2) * s ** (df - 1) * mp.exp(-df * s * s / 2)
        kept = lambda s: density(s) * (mp.ncdf(t * s - ncp) - mp.ncdf(-t * s - ncp))
        cases.append([df, ncp, float(1 - mp.quad(kept, [0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 3, 5, 10, 20]))])
    return cases


def two_sample_permutation():
    """Exact two-sample permutation test by full enumeration with exact integers."""
    a, b = [5, 6, 5, 7, 6], [7, 8, 7, 6, 9]
    pool = a + b
    observed = abs(sum(a) - sum(b))
    total = sum(pool)
    hits = sum(abs(2 * sum(c) - total) >= observed for c in itertools.combinations(pool, 5))
    return {"low": a, "high": b, "p": hits / 252}


fixture = {
    "versions": {"numpy": np.__version__, "scipy": scipy.__version__, "pandas": pd.__version__, "statsmodels": statsmodels.__version__, "mpmath": mp.__version__},
    "designs": [
        design_case("2^1 x 6", 1, 6, 1),
        design_case("2^2 x 3", 2, 3, 2),
        design_case("2^3 x 5", 3, 5, 3),
        design_case("2^3 x 5, 7 runs missing", 3, 5, 4, drop=7),
        design_case("2^4 x 2", 4, 2, 5),
        design_case("2^4 x 3, 9 runs missing", 4, 3, 6, drop=9),
        design_case("2^3 x 5, offset 1e3", 3, 5, 7, offset=1e3),
    ],
    "weighted": weighted_case(11),
    "anova": [anova_case(21, 0), anova_case(22, 5)],
    "box_cox": box_cox_case(31),
    "tails": tails(),
    "shapiro": shapiro_cases(),
    "power": power_cases(),
    "permutation": two_sample_permutation(),
}
OUT.parent.mkdir(parents=True, exist_ok=True)
parts = []
for key, value in fixture.items():
    if isinstance(value, list):
        parts.append(f"{json.dumps(key)}: [\n" + ",\n".join(json.dumps(item, allow_nan=False) for item in value) + "\n]")
    else:
        parts.append(f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}")
OUT.write_text("{" + ",\n".join(parts) + "}\n")
print(OUT, OUT.stat().st_size, "bytes")
