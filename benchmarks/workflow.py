"""Where the time of a run of the workflow went: of each rule, for starting Python, and idle.

python benchmarks/workflow.py results/standard --cores 2
"""

import argparse
import re
from pathlib import Path

import pandas as pd


def jobs(run: Path) -> pd.DataFrame:
    """For each job its rule, when it ended, its seconds, those of processors, and of the start."""
    rows = []
    for path in run.glob("benchmarks/**/*.tsv"):
        name = path.relative_to(run / "benchmarks").with_suffix("")
        log = (run / "logs" / name).with_suffix(".log").read_text(encoding="utf-8")
        cpu, start_up = map(float, re.search(r"done: ([\d.]+) s .* ([\d.]+) of", log).groups())
        seconds = pd.read_csv(path, sep="\t")["s"].item()
        rows.append((name.parts[0], path.stat().st_mtime, seconds, cpu, start_up))
    return pd.DataFrame(rows, columns=["rule", "end", "s", "cpu", "start_up"])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("run", type=Path, help="folder of the results")
    parser.add_argument("--cores", type=int, default=2)
    options = parser.parse_args()
    table = jobs(options.run)
    wall = table.end.max() - (table.end - table.s).min()
    columns = {"jobs": ("s", "size"), "job_s": ("s", "sum"), "cpu_s": ("cpu", "sum")}
    columns |= {"start_up_s": ("start_up", "sum"), "longest_s": ("s", "max")}
    print(table.groupby("rule").agg(**columns).sort_values("job_s").round(1).to_string())
    print(f"wall clock {wall:.0f} s, {len(table)} jobs of together {table.s.sum():.0f} s")
    print(f"starting Python {table.start_up.sum() / table.cpu.sum():.1%} of the processor time")
    print(f"cores idle {1 - table.s.sum() / wall / options.cores:.1%}")
