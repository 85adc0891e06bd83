"""How fast the integrators are, beside plain loops and general solvers: `beltrepro bench`."""
