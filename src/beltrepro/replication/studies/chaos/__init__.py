"""Which motions are chaotic, periodic or transient."""
