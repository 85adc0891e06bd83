# What a preset takes: time, memory and disk, from a sample of its simulation jobs.


rule timing:
    "What the preset takes, from one in ten of its simulation jobs: timing.csv."
    input:
        FLOW.sampled,
    output:
        table="<results>/timing.csv",
        about="<results>/timing.csv-metadata.json",
    log:
        "<logs>/timing.log",
    benchmark:
        "<benchmarks>/timing.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(500),
        runtime=at_attempt(5),
    params:
        jobs=FLOW.simulation_jobs(),
        benchmarks=f"results/{RUN}/benchmarks",
        code=FLOW.code("timing.py", "beltrepro.replication.plan.jobs:estimate"),
    message:
        "Estimating the time of the preset"
    script:
        "../scripts/timing.py"
