# Figures: one generic rule that draws from datasets, and each figure as a target of its own.


rule figure:
    "Draw a figure as PNG and PDF."
    input:
        unpack(figure_data),
    output:
        png="<results>/figures/{figure}.png",
        pdf="<results>/figures/{figure}.pdf",
    log:
        "<logs>/figures/{figure}.log",
    benchmark:
        "<benchmarks>/figures/{figure}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
        runtime=10,
    params:
        preset=PLAN.preset,
        code=figure_code,
    message:
        "Drawing {wildcards.figure}"
    script:
        "../scripts/figure.py"


# The targets below only give names: `snakemake --cores 2 fig12`. Their sentences are the titles in
# config.yaml (a test compares them).


localrules:
    figures,
    fig01,
    fig06,
    fig07,
    fig08,
    fig09,
    fig10,
    fig11,
    fig12,
    fig13,
    fig14,
    fig15,
    fig16,
    fig17,
    fig18,
    fig19,
    fig20,
    fig21,
    fig22,


rule figures:
    "All figures."
    input:
        figure_files,


rule fig01:
    "Scheme of the chain on the belt."
    input:
        multiext("<results>/figures/fig01", ".png", ".pdf"),


rule fig06:
    "Spring force against deformation, with its exponential branches."
    input:
        multiext("<results>/figures/fig06", ".png", ".pdf"),


rule fig07:
    "Friction force against external force during one stick-slip event, with noise."
    input:
        multiext("<results>/figures/fig07", ".png", ".pdf"),


rule fig08:
    "Position and relative velocity of the last block at u = 1, with the power spectrum."
    input:
        multiext("<results>/figures/fig08", ".png", ".pdf"),


rule fig09:
    "Distributions of slip sizes and of dissipated energies at u = 1."
    input:
        multiext("<results>/figures/fig09", ".png", ".pdf"),


rule fig10:
    "Poincaré section of the chaotic attractor at u = 1."
    input:
        multiext("<results>/figures/fig10", ".png", ".pdf"),


rule fig11:
    "Chaotic transient and periodic orbit at u = 20."
    input:
        multiext("<results>/figures/fig11", ".png", ".pdf"),


rule fig12:
    "Bifurcation diagram and r(u) without noise, with lifetimes of chaotic transients."
    input:
        multiext("<results>/figures/fig12", ".png", ".pdf"),


rule fig13:
    "Disorder parameter r(u) for several noise strengths."
    input:
        multiext("<results>/figures/fig13", ".png", ".pdf"),


rule fig14:
    "Bifurcation diagrams with noise, and r against noise at u = 7."
    input:
        multiext("<results>/figures/fig14", ".png", ".pdf"),


rule fig15:
    "Disorder parameter r against noise for u from 20 on."
    input:
        multiext("<results>/figures/fig15", ".png", ".pdf"),


rule fig16:
    "Noise-induced intermittency at u = 17.5, with the power spectrum."
    input:
        multiext("<results>/figures/fig16", ".png", ".pdf"),


rule fig17:
    "Natural distribution over belt velocity and velocity of the last block, for four noises."
    input:
        multiext("<results>/figures/fig17", ".png", ".pdf"),


rule fig18:
    "Map of r over belt velocity and noise, with the boundary of intermittency."
    input:
        multiext("<results>/figures/fig18", ".png", ".pdf"),


rule fig19:
    "Disorder parameter r(u) for several numbers of blocks."
    input:
        multiext("<results>/figures/fig19", ".png", ".pdf"),


rule fig20:
    "Intermittency of ten blocks without noise, at four belt velocities."
    input:
        multiext("<results>/figures/fig20", ".png", ".pdf"),


rule fig21:
    "Disorder parameter r against noise for several numbers of blocks."
    input:
        multiext("<results>/figures/fig21", ".png", ".pdf"),


rule fig22:
    "Bifurcation diagrams for 2, 3, 4, 6, 7 and 10 blocks."
    input:
        multiext("<results>/figures/fig22", ".png", ".pdf"),
