"""The statement with which a scenario file declares a class."""

import os
import sys

from ._parameter import parameters_of, quoted


def declaration(controller, command=None):
    """`controller my_av { … }`, to be put into a `.scn` beside the program, which is started by `command`."""
    lines = []
    if controller.__doc__ and controller.__doc__.strip():
        lines.append(quoted(controller.__doc__.strip().splitlines()[0]))
    lines.append("command " + ", ".join(quoted(word) for word in command or _command(controller)))
    lines.append(f"gives {controller.gives}")
    if controller.period is not None:
        milliseconds = round(1000 * controller.period)
        exact = milliseconds / 1000 == controller.period and milliseconds % 1000
        lines.append(f"period {milliseconds} ms" if exact else f"period {controller.period!r} s")
    lines += [one.statement() for one in parameters_of(controller)]
    return "\n".join([f"controller {controller.own_name()} {{", *(f"  {line}" for line in lines), "}"])


def _command(controller):
    main = sys.modules.get("__main__")
    spec = getattr(main, "__spec__", None)
    if spec is not None and spec.name:
        name = spec.name[: -len(".__main__")] if spec.name.endswith(".__main__") else spec.name
        return ["python3", "-m", name]
    path = getattr(main, "__file__", None)
    return ["python3", os.path.relpath(path) if path else f"{controller.__module__}.py"]
