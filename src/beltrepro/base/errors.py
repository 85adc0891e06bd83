"""Errors a user may see: each is one clear line."""


class InputError(ValueError):
    """A value is not allowed; the message names the key, the value and what is allowed."""


class ModelStateError(RuntimeError):
    """A run left the range of the model (NaN, or blocks that pass through each other)."""
