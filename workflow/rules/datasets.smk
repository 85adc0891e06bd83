# Datasets: their points are simulated in batches, runs are added where these are too few, and the
# batches are joined into one file.

FIRST, ADDED = "[0-9]{4}", "round[0-9]+_[0-9]{4}"


rule simulate:
    "Simulate one batch of points of a dataset."
    output:
        "<results>/batches/{dataset}/{batch}.h5",
    log:
        "<logs>/batches/{dataset}/{batch}.log",
    benchmark:
        "<benchmarks>/batches/{dataset}/{batch}.tsv"
    wildcard_constraints:
        batch=FIRST,
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(3000),
        runtime=FLOW.minutes_of_batch,
    params:
        spec=lambda wildcards: FLOW.plan.batch_spec(wildcards.dataset, wildcards.batch),
        code=FLOW.code_of_batch,
    message:
        "Simulating batch {wildcards.batch} of {wildcards.dataset}"
    script:
        "../scripts/simulate.py"


rule add_runs:
    "Add runs to the points of some rows of a dataset where their mean is not known well enough."
    input:
        FLOW.runs_so_far,
    output:
        "<results>/batches/{dataset}/{batch}.h5",
    log:
        "<logs>/batches/{dataset}/{batch}.log",
    benchmark:
        "<benchmarks>/batches/{dataset}/{batch}.tsv"
    wildcard_constraints:
        batch=ADDED,
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(3000),
        runtime=FLOW.minutes_of_batch,
    params:
        spec=lambda wildcards: FLOW.plan.batch_spec(wildcards.dataset, wildcards.batch),
        expected=FLOW.expected_batches,
        code=FLOW.code_of_batch,
    message:
        "Adding runs to {wildcards.dataset} ({wildcards.batch})"
    script:
        "../scripts/add_runs.py"


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
    wildcard_constraints:
        dataset=FLOW.joined(),
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(3000),
        runtime=at_attempt(10),
    params:
        spec=lambda wildcards: FLOW.plan.dataset_spec(wildcards.dataset),
        expected=FLOW.expected_batches,
        code=FLOW.code("join.py", "beltrepro.replication.plan.files:join"),
    message:
        "Joining the batches of {wildcards.dataset}"
    script:
        "../scripts/join.py"
