"""What a run found, in words and tables: the page, the article, the block of README.

Claims and estimates are read once (`results`) and become findings; page, article and block print
these. None of them computes a number.
"""
