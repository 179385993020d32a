"""What goes wrong, by kind; the texts are those of the C++ library and of the command."""


class Error(Exception):
    """Base of all errors of cylpose."""


class InputError(Error, ValueError):
    """A file, an argument or an image that cannot be used as it is."""


class OutputError(Error):
    """A result that cannot be written."""


class DeviceError(Error, RuntimeError):
    """A camera or compute device that is missing or failed."""
