"""The one way an estimator says that the data do not carry a number."""


class NotEnoughDataError(ValueError):
    """Too few, or the wrong, data for this estimate; the message is one line with the reason."""


def require(condition: object, reason: str) -> None:
    """Raise an error unless the condition holds."""
    if not condition:
        raise NotEnoughDataError(reason)
