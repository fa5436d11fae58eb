"""The value of a field that a sample was sent without."""

from sft._errors import AbsentError


class Absent:
    """Stands for a field that was not sent. Any use of the value raises an AbsentError, which names the field.

    If the subscriber names no fields, the read has requested the field, and later samples have it. `field` is its path.
    """

    __slots__ = ("field", "_is_recorded")
    __array_ufunc__ = None  # numpy leaves arithmetic to this class

    def __init__(self, field, is_recorded):
        object.__setattr__(self, "field", field)
        object.__setattr__(self, "_is_recorded", is_recorded)

    def __repr__(self):
        return f"<absent: {self.field}>"

    def __reduce__(self):
        return Absent, (self.field, self._is_recorded)

    def __format__(self, spec):
        return self._refuse() if spec else repr(self)

    def _refuse(self, *_, **__):
        what_to_do = ("it has been asked for, and later samples have it" if self._is_recorded
                      else "name it in the fields of the subscriber")
        raise AbsentError(f"'{self.field}' was not sent in this sample; {what_to_do}")

    def __getattr__(self, name):
        if name.startswith("__"):  # questions of Python and numpy about what the object can do
            raise AttributeError(name)
        return self._refuse()

    __hash__ = object.__hash__


for _name in ("add sub mul matmul truediv floordiv mod divmod pow lshift rshift and or xor radd rsub rmul rmatmul "
              "rtruediv rfloordiv rmod rdivmod rpow rlshift rrshift rand ror rxor neg pos abs invert lt le gt ge eq ne "
              "bool int float complex index round len getitem iter contains call array setattr").split():
    setattr(Absent, f"__{_name}__", Absent._refuse)
