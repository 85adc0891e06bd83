# The virtual experiment: datasets are filmed, and the last block is tracked in the films.


rule film:
    "Film a dataset with the virtual camera."
    input:
        unpack(FLOW.sources),
    output:
        video="<results>/experiment/{film}.mp4",
        about="<results>/experiment/{film}.mp4-metadata.json",
    log:
        "<logs>/experiment/{film}.film.log",
    benchmark:
        "<benchmarks>/experiment/{film}.film.tsv"
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
        code=FLOW.code("film.py", "beltrepro.replication.camera.camera:film"),
    message:
        "Filming {wildcards.film}"
    script:
        "../scripts/film.py"


rule track:
    "Track the last block in a film."
    input:
        "<results>/experiment/{film}.mp4",
    output:
        table="<results>/experiment/{film}.csv",
        about="<results>/experiment/{film}.csv-metadata.json",
    log:
        "<logs>/experiment/{film}.track.log",
    benchmark:
        "<benchmarks>/experiment/{film}.track.tsv"
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(1000),
        runtime=at_attempt(10),
    params:
        expected=FLOW.expected_of_film,
        code=FLOW.code("track.py", "beltrepro.replication.camera.tracking:track"),
    message:
        "Tracking {wildcards.film}"
    script:
        "../scripts/track.py"
