# Datasets: their points are simulated in batches, and the batches joined into one file.


rule simulate:
    "Simulate one batch of points of a dataset."
    output:
        "<results>/batches/{dataset}/{batch}.h5",
    log:
        "<logs>/batches/{dataset}/{batch}.log",
    benchmark:
        "<benchmarks>/batches/{dataset}/{batch}.tsv"
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=240,
    params:
        told=told_batch,
        code=batch_code,
    message:
        "Simulating batch {wildcards.batch} of {wildcards.dataset}"
    script:
        "../scripts/simulate.py"


rule join:
    "Join the batches of a dataset."
    input:
        batches,
    output:
        "<results>/datasets/{dataset}.h5",
    log:
        "<logs>/datasets/{dataset}.log",
    benchmark:
        "<benchmarks>/datasets/{dataset}.tsv"
    wildcard_constraints:
        dataset=joined(),
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        told=told_dataset,
        expected=expected_batches,
    message:
        "Joining the batches of {wildcards.dataset}"
    script:
        "../scripts/join.py"
