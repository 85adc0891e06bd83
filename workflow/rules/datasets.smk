# Datasets: their points are simulated in batches, and the batches are joined into one file.


rule simulate:
    "Simulate one batch of points of a dataset."
    output:
        "<results>/batches/{dataset}/{batch}.h5",
    log:
        "<logs>/batches/{dataset}/{batch}.log",
    benchmark:
        "<benchmarks>/batches/{dataset}/{batch}.tsv"
    wildcard_constraints:
        batch="[0-9]{4}",
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    params:
        spec=lambda wildcards: FLOW.plan.batch_spec(wildcards.dataset, wildcards.batch),
        code=FLOW.code_of_batch,
    message:
        "Simulating batch {wildcards.batch} of {wildcards.dataset}"
    script:
        "../scripts/simulate.py"


rule join:
    "Join the batches of a dataset."
    input:
        FLOW.batches,
    output:
        "<results>/datasets/{dataset}.h5",
    log:
        "<logs>/datasets/{dataset}.log",
    benchmark:
        "<benchmarks>/datasets/{dataset}.tsv"
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    params:
        spec=lambda wildcards: FLOW.plan.dataset_spec(wildcards.dataset),
        code=lambda wildcards: FLOW.code("join", "beltrepro.replication.plan.io"),
    message:
        "Joining the batches of {wildcards.dataset}"
    script:
        "../scripts/join.py"
