"""The studies, a folder a question: numbers, figures, claims and words."""
