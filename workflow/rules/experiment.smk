# The virtual experiment: datasets are filmed, and the last block is tracked in the films.


rule film:
    "Film a dataset with the virtual camera, and track the last block in the film."
    input:
        unpack(FLOW.sources),
    output:
        video="<results>/experiment/{film}.mp4",
        about_video="<results>/experiment/{film}.mp4-metadata.json",
        table="<results>/experiment/{film}.csv",
        about_table="<results>/experiment/{film}.csv-metadata.json",
    log:
        "<logs>/experiment/{film}.log",
    benchmark:
        "<benchmarks>/experiment/{film}.tsv"
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(1000),
        runtime=at_attempt(10),
    params:
        spec=lambda wildcards: FLOW.plan.films[wildcards.film].spec(),
        expected=FLOW.expected_of_sources,
        code=FLOW.code(
            "film.py",
            "beltrepro.replication.camera.camera:film",
            "beltrepro.replication.camera.track:track",
        ),
    message:
        "Filming and tracking {wildcards.film}"
    script:
        "../scripts/film.py"
