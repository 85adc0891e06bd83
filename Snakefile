# The workflow: config.yaml -> datasets -> tables, figures, claims and the report.
#
#     snakemake --cores 2                            everything, preset `standard`
#     snakemake --cores 2 --config preset=smoke      the same in a few minutes, coarse
#     snakemake --cores 2 fig12                      one figure, and the simulations it needs
#     snakemake --list                               all targets, with a sentence each

import re
import sys
from pathlib import Path

from snakemake.utils import min_version

min_version("9.12")  # the first that has `pathvars`


include: "workflow/rules/common.smk"


rule all:
    "Everything: figures, tables, claims and the report; the default."
    default_target: True
    input:
        FLOW.datasets.values(),
        FLOW.made.values(),
        FLOW.drawn("png", "pdf"),
        multiext("<results>/", "claims.csv", "estimates.csv", "report.html"),
    localrule: True


include: "workflow/rules/datasets.smk"
include: "workflow/rules/results.smk"


refuse_unknown_targets()


onstart:
    begin()


# Jobs go on after a failure: say once more, last, what each wrote of it in its log.
onerror:
    said = Path(log[0]).read_text(encoding="utf-8", errors="replace")
    for path in dict.fromkeys(re.findall(r"^ +log: ([^,\s]+).* \(check log", said, re.M)):
        text = Path(path).read_text(encoding="utf-8") if Path(path).exists() else ""
        words = re.search(r" ERROR (.+)", text)
        silent = (
            f"the job of {path} was stopped, or killed for want of memory: run the same again"
        )
        print(f"error: {words[1] if words else silent}", file=sys.stderr)
