"""What is measured while chains run (Sec. IV): observers eat the chunks of an ensemble."""
