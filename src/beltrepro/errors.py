"""Errors a user may see: each is one clear line."""


class InputError(ValueError):
    """A value given by the user is not allowed; the message names key, value and what is allowed."""


class ModelStateError(RuntimeError):
    """A run left the range of the model (NaN, or blocks that pass through each other)."""
