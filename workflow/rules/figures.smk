# Figures: one rule that draws any of them, and each figure as a target of its own.


localrules:
    figures,


rule draw:
    "Draw a figure as PNG and PDF."
    input:
        unpack(figure_data),
    output:
        png=report(
            "<results>/figures/{figure}.png",
            caption="../report/figure.rst",
            category=of_figure("category"),
            labels=figure_labels,
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
        mem_mb=2000,
        runtime=10,
    params:
        expected=expected_of_figure,
        title=of_figure("title"),
        words=of_figure("words"),
        code=figure_code,
    message:
        "Drawing {wildcards.figure}"
    script:
        "../scripts/figure.py"


rule figures:
    "All figures."
    input:
        drawn("png", "pdf"),


# Only names: `snakemake --cores 2 fig12`. Their sentences in `snakemake --list` are the titles.
for name, entry in FIGURES.items():

    rule:
        name:
            name
        input:
            multiext(f"<results>/figures/{name}", ".png", ".pdf"),
        localrule: True

    workflow.get_rule(name).docstring = entry.title
