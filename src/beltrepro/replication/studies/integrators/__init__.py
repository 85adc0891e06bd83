"""How far the integrators agree."""
