# A finished run made ready for a data repository. Neither target is part of `all`.


rule crate:
    "The results as an RO-Crate: what each job read and wrote, with the sources."
    input:
        everything(),
    output:
        "<results>/ro-crate-metadata.json",
        sources=directory("<results>/source"),
    log:
        "<logs>/crate.log",
    benchmark:
        "<benchmarks>/crate.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        told=told_crate,
        commit=lambda wildcards: provenance.code_version(),
        code=code_hash("beltrepro.extras.deposit", script="crate.py"),
    message:
        "Describing the run as an RO-Crate"
    script:
        "../scripts/crate.py"


rule archive:
    "One ZIP file for a data repository: sources, datasets, figures, report, checksums."
    input:
        everything(),
    output:
        f"<results>/beltrepro-{PLAN.run}.zip",
    log:
        "<logs>/archive.log",
    benchmark:
        "<benchmarks>/archive.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=60,
    params:
        told=told_crate,
        commit=lambda wildcards: provenance.code_version(),
        code=code_hash("beltrepro.extras.deposit", script="archive.py"),
    message:
        "Packing the archive"
    script:
        "../scripts/archive.py"
