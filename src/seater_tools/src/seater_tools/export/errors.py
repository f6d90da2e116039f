"""What can be wrong with an export."""


class ExportError(ValueError):
    """There is nothing to write, it is there already, or a library is missing."""
