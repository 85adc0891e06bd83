# Scans: many points (N, u, sigma), simulated in blocks and joined into one table.


rule scan_block:
    "Simulate one block of points of a scan."
    output:
        "<results>/blocks/{scan}/{block}.h5",
    log:
        "<logs>/blocks/{scan}/{block}.log",
    benchmark:
        "<benchmarks>/blocks/{scan}/{block}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=240,
    params:
        preset=PLAN.preset,
        settings=block_settings,
        code=block_code,
    message:
        "Simulating block {wildcards.block} of scan {wildcards.scan}"
    script:
        "../scripts/scan_block.py"


rule scan:
    "Join the blocks of a scan."
    input:
        scan_blocks,
    output:
        "<results>/scans/{scan}.h5",
    log:
        "<logs>/scans/{scan}.log",
    benchmark:
        "<benchmarks>/scans/{scan}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        settings=scan_settings,
    message:
        "Joining scan {wildcards.scan}"
    script:
        "../scripts/join.py"
