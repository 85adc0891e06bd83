# Claims, measured from the datasets; the report that shows everything, and the article.


rule claims:
    "A verdict for every claim of the paper, and the numbers it rests on."
    input:
        **{name: file_of(name) for name in EXPECTED.judged},
    output:
        claims=report("<results>/claims.csv", caption="../report/claims.rst", category="Claims"),
        estimates="<results>/estimates.csv",
        about=[f"<results>/{name}.csv-metadata.json" for name in ("claims", "estimates")],
    log:
        "<logs>/claims.log",
    benchmark:
        "<benchmarks>/claims.tsv"
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        settings=PLAN.settings(),
        expected=EXPECTED.each(*EXPECTED.judged),
        code=code_hash("beltrepro.replication.studies.measuring", script="claims.py"),
    message:
        "Measuring the claims"
    script:
        "../scripts/claims.py"


rule report:
    "One page with every figure, the table of claims and what was run: report.html."
    input:
        **{name: file_of(name) for name in TABLES},
        datasets=dataset_files(),
        claims="<results>/claims.csv",
        estimates="<results>/estimates.csv",
        figures=drawn("png"),
        compared=compared(),
    output:
        report("<results>/report.html", caption="../report/report.rst", category="Report"),
    log:
        "<logs>/report.log",
    benchmark:
        "<benchmarks>/report.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        preset=PLAN.preset,
        settings=PLAN.settings(),
        benchmarks=f"results/{PLAN.run}/benchmarks",
        expected=expected_of_report(),
        code=code_hash("beltrepro.replication.report.page", script="report.py"),
    message:
        "Writing the report"
    script:
        "../scripts/report.py"


rule article:
    "A short replication article, from the claims and figures: article.pdf."
    input:
        claims="<results>/claims.csv",
        estimates="<results>/estimates.csv",
        about="<results>/claims.csv-metadata.json",
        citation="CITATION.cff",
        figures=drawn("png"),
    output:
        report("<results>/article.pdf", caption="../report/article.rst", category="Article"),
    log:
        "<logs>/article.log",
    benchmark:
        "<benchmarks>/article.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        settings=PLAN.settings(),
        expected=expected_of_article(),
        code=code_hash("beltrepro.replication.report.article", script="article.py"),
    message:
        "Setting the article"
    script:
        "../scripts/article.py"
