# A finished run made ready for a data repository. Neither target is part of `all`.


rule crate:
    "The results as an RO-Crate: what each job read and wrote, with the sources."
    input:
        FLOW.everything(),
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
        mem_mb=at_attempt(1000),
        runtime=at_attempt(30),
    params:
        spec=lambda wildcards: FLOW.crate_spec(workflow.get_rule),
        commit=lambda wildcards: provenance.code_version(),
        code=FLOW.code("crate.py", "beltrepro.extras.deposit.archive:write_crate"),
    message:
        "Describing the run as an RO-Crate"
    script:
        "../scripts/crate.py"


rule archive:
    "One ZIP file for a data repository: sources, datasets, figures, report, checksums."
    input:
        FLOW.everything(),
    output:
        f"<results>/beltrepro-{RUN}.zip",
    log:
        "<logs>/archive.log",
    benchmark:
        "<benchmarks>/archive.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(1000),
        runtime=at_attempt(60),
    params:
        spec=lambda wildcards: FLOW.crate_spec(workflow.get_rule),
        commit=lambda wildcards: provenance.code_version(),
        code=FLOW.code("archive.py", "beltrepro.extras.deposit.archive:write"),
    message:
        "Packing the archive"
    script:
        "../scripts/archive.py"
