"""Reference for the orthogonal fit of the hem curve: seeded outlines, fitted by scipy.odr, polished until the gradient vanishes.

usage: python scripts/orthogonal_reference.py tests/fixtures        (numpy, scipy < 1.19; the versions used stand in the output)

Writes outlines.csv (profile,x_cm,y_cm) and orthogonal_reference.csv (profile,folds,p_cm,q_cm,s_cm,x0_cm,y0_cm,sum_of_squares_cm2).
The cases are curves whose free optimum is simple: few and many folds, shallow and overhanging, few and many points, clean and noisy.
"""
import csv
import sys

import numpy as np
import scipy
from scipy import odr, optimize

# folds, p, q, s (cm), points, noise (cm), spacing
CASES = [
    (2, 18.0, 1.5, 0.2, 90, 0.02, "even"),
    (3, 15.0, 2.5, 0.5, 120, 0.05, "jittered"),
    (5, 13.15, 5.27, 0.873, 180, 0.05, "jittered"),
    (5, 13.15, 5.27, 0.873, 180, 0.0, "even"),
    (6, 16.3, 4.9, 0.27, 180, 0.05, "jittered"),
    (7, 12.46, 3.87, 0.632, 240, 0.1, "jittered"),
    (8, 20.0, 3.0, 1.5, 360, 0.1, "jittered"),
    (8, 20.0, 3.0, 1.5, 160, 0.02, "random"),
    (11, 25.0, 2.0, -0.4, 200, 0.03, "jittered"),
    (14, 22.0, 1.2, 0.5, 300, 0.03, "jittered"),
    (24, 30.0, 0.8, 0.1, 400, 0.02, "even"),
    (4, 12.0, 0.4, 0.05, 60, 0.02, "jittered"),
]


def curve(t, b, m):
    x0, y0, phase, p, q, s = b
    a = t + phase
    rho, tau = p + q * np.cos(m * t), s * np.sin(2 * m * t)
    return np.array([x0 + rho * np.cos(a) - tau * np.sin(a), y0 + rho * np.sin(a) + tau * np.cos(a)])


def distances(points, t, b, m):
    """Signed distances at foot points, found by a safeguarded one-dimensional search for each point."""
    feet = np.empty_like(t)
    for i, (x, y) in enumerate(points.T):
        square = lambda u: float(((curve(np.array([u]), b, m)[:, 0] - (x, y)) ** 2).sum())
        width = np.pi / (4 * m)
        found = optimize.minimize_scalar(square, bracket=(t[i] - width, t[i], t[i] + width), method="brent", options=dict(xtol=1e-15))
        feet[i] = found.x
    return feet


def sum_of_squares(points, t, b, m):
    e = points - curve(distances(points, t, b, m), b, m)
    return float((e * e).sum())


def reference(points, t, truth, m):
    model = odr.Model(lambda b, t: curve(t, b, m))
    # Points are observed in both coordinates; the parameter t is free (weight of its own error next to nothing).
    fit = odr.ODR(odr.Data(t, points, wd=1e-12, we=1.0), model, beta0=truth, maxit=500, sstol=1e-16, partol=1e-16)
    result = fit.run()
    b, t = result.beta, t + result.delta
    # Newton on the reduced problem: the Jacobian of the distances is exact at foot points.
    for _ in range(6):
        t = distances(points, t, b, m)
        h = 1e-6
        d1 = (curve(t + h, b, m) - curve(t - h, b, m)) / (2 * h)
        normal = np.array([d1[1], -d1[0]]) / np.hypot(*d1)
        d = ((points - curve(t, b, m)) * normal).sum(0)
        jacobian = np.empty((t.size, 6))
        for j in range(6):
            step = np.zeros(6)
            step[j] = 1e-6 * max(1.0, abs(b[j]))
            jacobian[:, j] = -(((curve(t, b + step, m) - curve(t, b - step, m)) / (2 * step[j])) * normal).sum(0)
        change = np.linalg.lstsq(jacobian, -d, rcond=None)[0]
        b = b + change
        if np.abs(change).max() < 1e-13:
            break
    return b, sum_of_squares(points, t, b, m)


def main(folder):
    outlines, results = [], []
    for k, (m, p, q, s, n, noise, spacing) in enumerate(CASES):
        g = np.random.default_rng(1000 + k)
        truth = np.array([g.uniform(-5, 5), g.uniform(-5, 5), g.uniform(0, 2 * np.pi / m), p, q, s])
        jitter = {"even": 0.5, "jittered": g.uniform(0, 1, n)}
        t = np.sort(g.uniform(0, 2 * np.pi, n)) if spacing == "random" else 2 * np.pi * (np.arange(n) + jitter[spacing]) / n
        points = np.round(curve(t, truth, m) + noise * g.standard_normal((2, n)), 12)
        b, square = reference(points, t, truth, m)
        outlines += [(k, x, y) for x, y in points.T]
        results.append((k, m, *(b[3:] if b[4] > 0 else (b[3], -b[4], b[5])), b[0], b[1], square))
    versions = f"# numpy {np.__version__}, scipy {scipy.__version__}\n"
    with open(f"{folder}/outlines.csv", "w") as f:
        f.write("profile,x_cm,y_cm\n")
        f.writelines(f"{k},{x:.12f},{y:.12f}\n" for k, x, y in outlines)
    with open(f"{folder}/orthogonal_reference.csv", "w") as f:
        f.write(versions)
        writer = csv.writer(f, lineterminator="\n")
        writer.writerow("profile,folds,p_cm,q_cm,s_cm,x0_cm,y0_cm,sum_of_squares_cm2".split(","))
        writer.writerows([(k, m, *(f"{v:.15g}" for v in rest)) for k, m, *rest in results])


if __name__ == "__main__":
    main(sys.argv[1])
