# Datasets: their points are simulated, those of large ones in batches that are joined. Some are
# filmed, and the last block is tracked in the films.
#
# `code` among the params is a hash of all modules behind a job. Snakemake sees no imports, but runs
# a job again whose params have changed.


rule compile:
    "Compile an integrator: jobs that did so for themselves would take twice as long."
    output:
        touch("<results>/kernels/{method}.compiled"),
    log:
        "<logs>/kernels/{method}.log",
    benchmark:
        "<benchmarks>/kernels/{method}.tsv"
    # no hash of its code: Snakemake looks at nothing behind a job that runs again, and starts none
    # whose input from it is `ancient`; so stale results would stay
    message:
        "Compiling {wildcards.method}"
    script:
        "../scripts/compile.py"


rule simulate:
    "Simulate one batch of points of a dataset."
    input:
        # for the order alone: kernels that are compiled again change no result
        ancient(FLOW.kernels),
    output:
        "<results>/batches/{dataset}/{batch}.h5",
    log:
        "<logs>/batches/{dataset}/{batch}.log",
    benchmark:
        "<benchmarks>/batches/{dataset}/{batch}.tsv"
    wildcard_constraints:
        batch="[0-9]+",
    params:
        spec=lambda wildcards: FLOW.plan.spec(wildcards.dataset, wildcards.get("batch")),
        points=FLOW.points,
        arrays=lambda wildcards: [*FLOW.plan.datasets[wildcards.dataset].kind.recorded],
        code=FLOW.code_of_batch,
    message:
        "Simulating batch {wildcards.batch} of {wildcards.dataset}"
    script:
        "../scripts/simulate.py"


use rule simulate as simulate_whole with:
    output:
        "<results>/datasets/{dataset}.h5",
    log:
        "<logs>/batches/{dataset}.log",
    benchmark:
        "<benchmarks>/batches/{dataset}.tsv"
    wildcard_constraints:
        dataset=FLOW.of_one_batch(),
    message:
        "Simulating {wildcards.dataset}"


# Both make the file of a dataset, and what is one batch needs no join.
ruleorder: simulate_whole > join


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
    params:
        spec=lambda wildcards: FLOW.plan.spec(wildcards.dataset),
        code=lambda wildcards: FLOW.code("join", FILES),
    message:
        "Joining the batches of {wildcards.dataset}"
    script:
        "../scripts/join.py"


rule film:
    "Film a dataset with the virtual camera, and track the last block in the film."
    input:
        unpack(lambda wildcards: FLOW.files([wildcards.film])),
    output:
        video="<results>/experiment/{film}.mp4",
        table="<results>/experiment/{film}.csv",
    log:
        "<logs>/experiment/{film}.log",
    benchmark:
        "<benchmarks>/experiment/{film}.tsv"
    params:
        spec=lambda wildcards: FLOW.plan.films[wildcards.film],
        code=lambda wildcards: FLOW.code(
            "film",
            FILES,
            "beltrepro.replication.camera.camera",
            "beltrepro.replication.camera.track",
        ),
    message:
        "Filming and tracking {wildcards.film}"
    script:
        "../scripts/film.py"
