"""What is measured while chains run (Sec. IV): observers read each chunk of a run."""
