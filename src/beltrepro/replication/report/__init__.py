"""What a run found, in words and tables: the page, the article, the block of README.

`claim_results` reads claims and estimates once, and they become findings; page, article and block
print these. None of them computes a number.
"""
