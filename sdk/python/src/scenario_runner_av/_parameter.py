"""Parameters of controllers: declared in a class, set by a scenario, told to the runner."""

import math
import re

UNITS = ("", "m", "s", "m/s", "m/s^2", "m/s^3", "rad", "rad/s", "Hz")
RESERVED = "in of from when with undefined and not true false step times by".split()
# As the runner calls them where they are called differently in files.
_SAID = {"Hz": "1/s"}


class parameter:
    """A parameter of a controller, an attribute of its class.

    A number needs `low` and `high` and is in `unit` (SI); a whole number has a whole default and bounds. A word has
    `options`. True or False is a flag, any other text a text. Of an instance it is the value in that run.
    """

    def __init__(self, default, unit="", *, low=None, high=None, options=None, doc=""):
        self.default, self.unit, self.low, self.high, self.doc = default, unit, low, high, doc
        self.options = None if options is None else tuple(options)
        self.name = None
        self.kind = self._kind()
        if self.kind in ("number", "whole"):
            if low is None or high is None:
                raise TypeError("a number needs a range: `low` and `high`")
            if not all(map(math.isfinite, (default, low, high))) or not low <= default <= high or low == high:
                raise ValueError(f"the default {default} is not within {low} .. {high}")
            if unit not in UNITS:
                raise ValueError(f"`{unit}` is no SI unit that scenarios know; there are {', '.join(UNITS[1:])}")
            if self.kind == "whole" and unit:
                raise TypeError("a whole number has no unit; write the default or a bound with a decimal point")
        elif low is not None or high is not None or unit:
            raise TypeError("a range and a unit are for numbers")

    def _kind(self):
        if self.options is not None:
            if self.default not in self.options:
                raise ValueError(f"the default {self.default!r} is none of the options {list(self.options)}")
            if not all(is_name(option) for option in self.options):
                raise ValueError("options are words of letters, digits and `_`")
            return "word"
        if isinstance(self.default, bool):
            return "flag"
        if isinstance(self.default, str):
            return "text"
        if all(isinstance(one, int) for one in (self.default, self.low, self.high)) and not self.unit:
            return "whole"
        if isinstance(self.default, (int, float)):
            return "number"
        raise TypeError(f"a default is a number, a text, True or False, not {self.default!r}")

    def __set_name__(self, owner, name):
        if not is_name(name):
            raise ValueError(f"`{name}` cannot be the name of a parameter in a scenario")
        self.name = name

    def __get__(self, instance, owner=None):
        # A run's value stands in the instance itself and is found first.
        return self if instance is None else self.default

    def said(self):
        """As the program says it in its hello."""
        said = {"name": self.name, "default": self.default}
        if self.kind in ("number", "whole"):
            said.update(unit=_SAID.get(self.unit, self.unit), low=self.low, high=self.high)
        if self.options is not None:
            said["options"] = list(self.options)
        if self.doc:
            said["doc"] = self.doc
        return said

    def statement(self):
        """As a file declares it."""
        if self.kind in ("number", "whole"):
            whole = "whole " if self.kind == "whole" else ""
            value = f"{_number(self.default, self.unit)} in {whole}{_number(self.low, self.unit)} .. {_number(self.high, self.unit)}"
        elif self.kind == "flag":
            value = "true" if self.default else "false"
        elif self.kind == "word":
            value = f"{self.default} in [{', '.join(self.options)}]"
        else:
            value = quoted(self.default)
        doc = f" {quoted(self.doc)}" if self.doc else ""
        return f"parameter {self.name} = {value}{doc}"


def parameters_of(controller):
    """The parameters of a class, those of its bases first."""
    found = {}
    for one in reversed(controller.__mro__):
        found.update((name, value) for name, value in vars(one).items() if isinstance(value, parameter))
    # What a class has put in the place of a parameter of its base is none any more.
    return [value for name, value in found.items() if getattr(controller, name) is value]


def is_name(text):
    """Whether scenarios may call something like this."""
    return isinstance(text, str) and re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", text) is not None and text not in RESERVED


def quoted(text):
    """A text of a scenario file, in one line."""
    line = " ".join(str(text).split())
    return '"' + line.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _number(value, unit):
    text = repr(value)
    if text.endswith(".0"):
        text = text[:-2]
    return f"{text} {unit}".rstrip()
