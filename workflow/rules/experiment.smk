# The virtual experiment: datasets are filmed, and the last block is tracked in the films.


rule film:
    "Film a dataset with the virtual camera, and track the last block in the film."
    input:
        unpack(FLOW.sources),
    output:
        video="<results>/experiment/{film}.mp4",
        table="<results>/experiment/{film}.csv",
    log:
        "<logs>/experiment/{film}.log",
    benchmark:
        "<benchmarks>/experiment/{film}.tsv"
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    params:
        spec=lambda wildcards: FLOW.plan.films[wildcards.film].spec(),
        code=lambda wildcards: FLOW.code(
            "film",
            "beltrepro.replication.camera.camera",
            "beltrepro.replication.camera.track",
        ),
    message:
        "Filming and tracking {wildcards.film}"
    script:
        "../scripts/film.py"
