"""A virtual experiment, and the measurement of a film at a known scale (Sec. II).

`camera.film` turns a run into a video as a camera above a treadmill would take it, and
`track.track` finds the white block in such a video (docs/experiment.md). Lengths are in metres and
times in seconds.
"""
