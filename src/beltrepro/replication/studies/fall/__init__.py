"""Why r falls: the end of orbits, the basin of starts at rest, or the way in which u changes."""
