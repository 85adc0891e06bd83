# Results: tables, figures, each a target of its own, claims, and the report that shows everything.
# Rules that only name files are local, so that a cluster gets no job for them.


rule derive:
    "Derive a table from datasets."
    input:
        unpack(lambda wildcards: FLOW.files(FLOW.tables[wildcards.table].uses)),
    output:
        table="<results>/tables/{table}.csv",
    log:
        "<logs>/tables/{table}.log",
    benchmark:
        "<benchmarks>/tables/{table}.tsv"
    params:
        about=lambda wildcards: vars(FLOW.tables[wildcards.table]),
        code=lambda wildcards: FLOW.code("derive", FILES, FLOW.tables[wildcards.table].module),
    message:
        "Deriving {wildcards.table}.csv"
    script:
        "../scripts/derive.py"


rule draw:
    "Draw a figure as PNG and PDF."
    input:
        unpack(lambda wildcards: FLOW.files(FLOW.figures[wildcards.figure].uses)),
    output:
        png="<results>/figures/{figure}.png",
        pdf="<results>/figures/{figure}.pdf",
    log:
        "<logs>/figures/{figure}.log",
    benchmark:
        "<benchmarks>/figures/{figure}.tsv"
    params:
        module=lambda wildcards: FLOW.figures[wildcards.figure].module,
        code=lambda wildcards: FLOW.code(
            "figure",
            FILES,
            FLOW.figures[wildcards.figure].module,
            "beltrepro.replication.drawing.style",
        ),
    message:
        "Drawing {wildcards.figure}"
    script:
        "../scripts/figure.py"


rule figures:
    "All figures."
    input:
        FLOW.drawn("png", "pdf"),
    localrule: True


# Only names: `snakemake --cores 2 fig12`. Their sentences in `snakemake --list` are the titles.
for name, entry in FLOW.figures.items():

    rule:
        name:
            name
        input:
            multiext(f"<results>/figures/{name}", ".png", ".pdf"),
        localrule: True

    workflow.get_rule(name).docstring = entry.title


rule claims:
    "A verdict for every claim of the paper, and the numbers it rests on."
    input:
        **FLOW.files(FLOW.judged),
    output:
        claims="<results>/claims.csv",
        estimates="<results>/estimates.csv",
    log:
        "<logs>/claims.log",
    benchmark:
        "<benchmarks>/claims.tsv"
    params:
        settings=FLOW.plan.settings(),
        shown={name: figure.shows for name, figure in FLOW.figures.items()},
        code=lambda wildcards: FLOW.code(
            "claims",
            FILES,
            "beltrepro.replication.studies.every_claim",
        ),
    message:
        "Measuring the claims"
    script:
        "../scripts/claims.py"


rule report:
    "One page with every figure, the table of claims and what was run: report.html."
    input:
        **FLOW.files(FLOW.tables),
        datasets=FLOW.datasets.values(),
        claims="<results>/claims.csv",
        estimates="<results>/estimates.csv",
        figures=FLOW.drawn("png"),
    output:
        "<results>/report.html",
    log:
        "<logs>/report.log",
    benchmark:
        "<benchmarks>/report.tsv"
    params:
        preset=FLOW.plan.preset,
        settings=FLOW.plan.settings(),
        benchmarks=f"results/{RUN}/benchmarks",
        # of all jobs this one alone prints captions
        code=lambda wildcards: FLOW.code("report", "beltrepro.replication.report.page", words=True),
    message:
        "Writing the report"
    script:
        "../scripts/report.py"
