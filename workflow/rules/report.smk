# Claims, measured from the datasets; and the report that shows everything.


rule claims:
    "A verdict for every claim of the paper, and the numbers it rests on."
    input:
        **FLOW.files_of(*FLOW.judged),
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
        mem_mb=at_attempt(5000),
        runtime=at_attempt(30),
    params:
        settings=FLOW.plan.settings(),
        expected=FLOW.expected(*FLOW.judged),
        code=FLOW.code("claims.py", "beltrepro.replication.studies.every_claim:measure"),
    message:
        "Measuring the claims"
    script:
        "../scripts/claims.py"


rule report:
    "One page with every figure, the table of claims and what was run: report.html."
    input:
        **FLOW.files_of(*FLOW.tables),
        datasets=FLOW.datasets(),
        claims="<results>/claims.csv",
        estimates="<results>/estimates.csv",
        figures=FLOW.drawn("png"),
        compared=FLOW.compared(),
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
        mem_mb=at_attempt(1500),
        runtime=at_attempt(10),
    params:
        preset=FLOW.plan.preset,
        settings=FLOW.plan.settings(),
        benchmarks=f"results/{RUN}/benchmarks",
        expected=FLOW.expected_of_report(),
        code=FLOW.code("report.py", "beltrepro.replication.report.page:render"),
    message:
        "Writing the report"
    script:
        "../scripts/report.py"
