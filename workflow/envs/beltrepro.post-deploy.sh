#!/usr/bin/env bash
# The pinned packages and this project, for the environment that conda has made. Snakemake calls
# it from the top folder of the project.
set -euo pipefail
python -m pip install --no-build-isolation --require-hashes --only-binary :all: --no-binary connection-pool \
  -r requirements.txt
python -m pip install --no-build-isolation --no-deps -e .
