"""The plan of a run: configuration, datasets, files, jobs and where they come from."""
