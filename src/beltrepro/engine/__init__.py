"""Integrators of Eq. 1 for many chains at once, and the driver that feeds observers."""
