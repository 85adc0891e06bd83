"""Commands of `beltrepro`: of chains, of films, of results, and what they share (`options`)."""
