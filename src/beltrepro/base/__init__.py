"""What every part stands on: errors, checks of input, files that appear whole, provenance."""
