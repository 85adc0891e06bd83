"""A run made ready for a data repository: crate, archive, checksums."""
