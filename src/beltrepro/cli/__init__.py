"""Commands of `beltrepro` with a module each, and what all commands share (`options`)."""
