"""The exceptions of SFT."""


class Error(RuntimeError):
    """What SFT refuses, with the text of the library. `code` is its category, such as 'invalid_argument'."""

    def __init__(self, message, code="unavailable"):
        super().__init__(message)
        self.code = code

    def __reduce__(self):
        return type(self), (str(self), self.code)


class AbsentError(Error):
    """A field was used that the sample was sent without."""
