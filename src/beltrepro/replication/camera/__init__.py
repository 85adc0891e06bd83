"""A virtual experiment, and the measurement of a real one: camera, video, tracking (Sec. II).

`camera.film` turns a run into a video as a camera above a treadmill would take it, and
`tracking.track` finds the white block in such a video, or in one of your own treadmill
(docs/experiment.md). Lengths are in metres and times in seconds.
"""
