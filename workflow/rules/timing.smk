# What a preset takes: time, memory and disk, from a sample of its simulation jobs.


rule timing:
    "What the preset takes, from one in ten of its simulation jobs: timing.csv."
    input:
        sampled_jobs,
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
        mem_mb=500,
        runtime=5,
    params:
        jobs=SIMULATION_JOBS,
        benchmarks=f"results/{PLAN.run}/benchmarks",
        code=code_hash("beltrepro.replication.plan.jobs", script="timing.py"),
    message:
        "Estimating the time of the preset"
    script:
        "../scripts/timing.py"
