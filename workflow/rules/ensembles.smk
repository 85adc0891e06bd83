# Ensembles: many slightly different initial states, one job for each belt velocity.


rule ensemble_member:
    "Simulate an ensemble at one belt velocity."
    output:
        "<results>/ensembles/{ensemble}/{member}.h5",
    log:
        "<logs>/ensembles/{ensemble}/{member}.log",
    benchmark:
        "<benchmarks>/ensembles/{ensemble}/{member}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=240,
    params:
        preset=PLAN.preset,
        settings=member_settings,
        code=member_code,
    message:
        "Simulating ensemble {wildcards.ensemble} at u = {params.settings[belt_velocity]}"
    script:
        "../scripts/ensemble_member.py"


rule ensemble:
    "Join the belt velocities of an ensemble."
    input:
        ensemble_members,
    output:
        "<results>/ensembles/{ensemble}.h5",
    log:
        "<logs>/ensembles/{ensemble}.log",
    benchmark:
        "<benchmarks>/ensembles/{ensemble}.tsv"
    conda:
        "../envs/beltrepro.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=10,
    params:
        settings=ensemble_settings,
    message:
        "Joining ensemble {wildcards.ensemble}"
    script:
        "../scripts/join.py"
