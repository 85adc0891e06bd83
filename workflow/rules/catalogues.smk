# Catalogues: slips, avalanches and section points of several chains with the same parameters.


rule catalogue:
    "Simulate and record slips, avalanches and section points."
    output:
        "<results>/catalogues/{catalogue}.h5",
    log:
        "<logs>/catalogues/{catalogue}.log",
    benchmark:
        "<benchmarks>/catalogues/{catalogue}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=240,
    params:
        preset=PLAN.preset,
        settings=catalogue_settings,
        code=catalogue_code,
    message:
        "Recording catalogue {wildcards.catalogue}"
    script:
        "../scripts/catalogue.py"
