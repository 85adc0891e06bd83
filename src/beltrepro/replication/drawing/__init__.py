"""What figures share: style, panels, replicates."""
