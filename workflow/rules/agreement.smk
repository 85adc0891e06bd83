# The comparison of two integrators: runs by both, tables, figures. The report shows them.


localrules:
    agreement,


rule agreement_runs:
    "Simulate one part of the comparison by one integrator."
    output:
        "<results>/agreement/{part}/{role}.h5",
    log:
        "<logs>/agreement/{part}/{role}.log",
    benchmark:
        "<benchmarks>/agreement/{part}/{role}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=240,
    params:
        preset=PLAN.preset,
        settings=agreement_settings,
        code=agreement_run_code,
    message:
        "Simulating {wildcards.part} by {params.settings[method]} for the comparison"
    script:
        "../scripts/agreement_runs.py"


rule agreement_tables:
    "Compare the runs of the two integrators."
    input:
        agreement_files(),
    output:
        comparisons="<results>/agreement.csv",
        families="<results>/agreement/families.csv",
        partings="<results>/agreement/trajectories.csv",
        convergence="<results>/agreement/convergence.csv",
    log:
        "<logs>/agreement/tables.log",
    benchmark:
        "<benchmarks>/agreement/tables.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        reference_step=PLAN.numerics.time_step,
        code=code_hash("beltrepro.analysis.agreement"),
    message:
        "Comparing the integrators"
    script:
        "../scripts/agreement_tables.py"


rule agreement:
    "Whether the two integrators agree: agreement.csv and its figures."
    input:
        "<results>/agreement.csv",
        drawn("png", "pdf", category="Integrators compared"),
