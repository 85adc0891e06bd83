# Tables that analyses derive from datasets. Beside each CSV file lies what made it (CSV on the Web).


localrules:
    agreement,


rule derive:
    "Derive a table from datasets."
    input:
        unpack(FLOW.sources),
    output:
        table="<results>/{table}.csv",
        about="<results>/{table}.csv-metadata.json",
    log:
        "<logs>/{table}.log",
    benchmark:
        "<benchmarks>/{table}.tsv"
    priority: BEFORE_FIGURES
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(4000),
        runtime=at_attempt(15),
    params:
        module=FLOW.about("module"),
        title=FLOW.about("title"),
        columns=FLOW.about("columns"),
        expected=FLOW.expected_of_sources,
        code=FLOW.code_of_table,
    message:
        "Deriving {wildcards.table}.csv"
    script:
        "../scripts/derive.py"


rule agreement:
    "Whether the two integrators agree: agreement.csv and its figures."
    input:
        FLOW.file_of("agreement"),
        FLOW.drawn("png", "pdf", category="Integrators compared"),
