"""What can stop an export."""


class ExportError(Exception):
    """The scene cannot be rendered. The text names the object and says what to do."""


class ExportCancelled(Exception):
    """The user stopped the render while its scene was being read."""
