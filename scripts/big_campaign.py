"""Many seeded drape profiles in one Parquet file, written row group by row group: what `hemline fit --into` is measured on.

usage: python scripts/big_campaign.py OUT.parquet [--profiles 100000] [--points 360] [--rows 1000000] [--seed 1]      (numpy, pyarrow)

Columns profile (int32), x_cm, y_cm (float64). Every profile is the paper's curve with 3 to 10 folds, p 15–25 cm, q 1–4 cm, s from −0.3 to 1 cm (at most a third of q),
any centre and phase, jittered steps and normal noise of 0.5 mm. Row groups end wherever the number of rows is reached, so most profiles at their ends span two groups.
The same arguments give the same numbers.
"""
import argparse

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq


def profiles(first, count, n, seed):
    """x and y, cm, of `count` profiles of n points; profile k depends on the seed and k alone by blocks of 1000."""
    random = np.random.default_rng([seed, first])
    m = random.integers(3, 11, (count, 1))
    p = random.uniform(15, 25, (count, 1))
    q = random.uniform(1, 4, (count, 1))
    s = np.minimum(random.uniform(-0.3, 1.0, (count, 1)), q / 3)
    x0, y0 = random.uniform(-5, 5, (2, count, 1))
    phase = random.uniform(0, 2 * np.pi, (count, 1))
    t = 2 * np.pi * (np.arange(n) + random.uniform(-0.3, 0.3, (count, n))) / n
    rho, tau = p + q * np.cos(m * t), s * np.sin(2 * m * t)
    a = t + phase
    x = x0 + rho * np.cos(a) - tau * np.sin(a) + random.normal(0, 0.05, (count, n))
    y = y0 + rho * np.sin(a) + tau * np.cos(a) + random.normal(0, 0.05, (count, n))
    return x.ravel(), y.ravel()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("out")
    parser.add_argument("--profiles", type=int, default=100_000)
    parser.add_argument("--points", type=int, default=360)
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    schema = pa.schema([("profile", pa.int32()), ("x_cm", pa.float64()), ("y_cm", pa.float64())])
    block = 1000
    with pq.ParquetWriter(args.out, schema) as writer:
        held = None
        for first in range(0, args.profiles, block):
            count = min(block, args.profiles - first)
            x, y = profiles(first, count, args.points, args.seed)
            names = np.repeat(np.arange(first + 1, first + count + 1, dtype=np.int32), args.points)
            table = pa.table([names, x, y], schema=schema)
            held = table if held is None else pa.concat_tables([held, table])
            while args.rows <= held.num_rows:
                writer.write_table(held.slice(0, args.rows), row_group_size=args.rows)
                held = held.slice(args.rows).combine_chunks()
        if held is not None and held.num_rows:
            writer.write_table(held, row_group_size=args.rows)


main()
