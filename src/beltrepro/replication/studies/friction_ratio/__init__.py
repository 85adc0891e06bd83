"""Where r falls for other friction ratios."""
