"""The one way an estimator says that the data do not carry a number."""


class NotEnoughDataError(ValueError):
    """Too few, or the wrong, data for this estimate; the message is one line with the reason."""


def require(condition: object, reason: str) -> None:
    """Raise an error unless the condition holds.

    Parameters
    ----------
    condition : bool
        What must be true of the data.
    reason : str
        Message of the error, one line.

    Raises
    ------
    NotEnoughDataError
        If `condition` is false.
    """
    if not condition:
        raise NotEnoughDataError(reason)
