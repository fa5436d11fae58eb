"""The exceptions of SFT."""


class Error(RuntimeError):
    """An error of SFT, with the text of the library. `code` is its category, such as 'invalid_argument'."""

    # There is no __init__: the library makes exceptions on threads that Python ends, with all frames of C++ on them, if
    # they run code of Python while the interpreter ends.

    def __str__(self):
        return str(self.args[0]) if self.args else ""

    @property
    def code(self):
        return self.args[1] if len(self.args) > 1 else "unavailable"


class AbsentError(Error):
    """The program has used a field that the sample was sent without."""
