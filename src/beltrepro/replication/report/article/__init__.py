"""The article: a short account of a run as PDF, each number from its tables of claims."""

from beltrepro.replication.report.article.contents import Material, content, name_of
from beltrepro.replication.report.article.setting import write

__all__ = ["Material", "content", "name_of", "write"]
