# The workflow: config.yaml -> datasets -> tables, figures, claims and the report.
#
#     snakemake --cores 2                            everything, preset `standard`
#     snakemake --cores 2 --config preset=smoke      the same in a few minutes, coarse
#     snakemake --cores 2 fig12                      one figure, and the simulations it needs
#     snakemake --list                               all targets, with a sentence each

from snakemake.utils import min_version

min_version("9.12")


configfile: "config.yaml"


include: "workflow/rules/common.smk"


localrules:
    all,


rule all:
    "Everything: figures, claims, the comparison of integrators, and the report; the default."
    default_target: True
    input:
        FLOW.everything(),


include: "workflow/rules/datasets.smk"
include: "workflow/rules/experiment.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"


refuse_unknown_targets()


onstart:
    begin()


# Jobs go on after a failure: say once more, last, what was wrong.
onerror:
    atexit.register(print, FAILURES.summary(log), file=sys.stderr)
