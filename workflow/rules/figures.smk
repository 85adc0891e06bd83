# Figures: one rule that draws any of them, and each figure as a target of its own.


localrules:
    figures,


rule draw:
    "Draw a figure as PNG and PDF."
    input:
        unpack(FLOW.sources),
    output:
        png=report(
            "<results>/figures/{figure}.png",
            caption="../report/figure.rst",
            category=FLOW.about("category"),
            labels=lambda wildcards: {
                "figure": wildcards.figure,
                "title": FLOW.about("title")(wildcards),
            },
        ),
        pdf="<results>/figures/{figure}.pdf",
    log:
        "<logs>/figures/{figure}.log",
    benchmark:
        "<benchmarks>/figures/{figure}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=at_attempt(2500),
        runtime=at_attempt(10),
    params:
        expected=FLOW.expected_of_figure,
        module=FLOW.about("module"),
        title=FLOW.about("title"),
        words=FLOW.about("words"),
        code=FLOW.code_of_figure,
    message:
        "Drawing {wildcards.figure}"
    script:
        "../scripts/figure.py"


rule figures:
    "All figures."
    input:
        FLOW.drawn("png", "pdf"),


# Only names: `snakemake --cores 2 fig12`. Their sentences in `snakemake --list` are the titles.
for name, entry in FLOW.figures.items():

    rule:
        name:
            name
        input:
            multiext(f"<results>/figures/{name}", ".png", ".pdf"),
        localrule: True

    workflow.get_rule(name).docstring = entry.title
