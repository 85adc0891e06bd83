# Series: one sampled trajectory each.


rule series:
    "Simulate and sample one trajectory."
    output:
        "<results>/series/{series}.h5",
    log:
        "<logs>/series/{series}.log",
    benchmark:
        "<benchmarks>/series/{series}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=240,
    params:
        preset=PLAN.preset,
        settings=series_settings,
        code=series_code,
    message:
        "Simulating series {wildcards.series}"
    script:
        "../scripts/series.py"
