"""Statistics of runs: arrays in, numbers with their errors out; no file and no figure."""
