"""Parent mode: this Python starts the runner and decides for a controller, in this very process."""

import contextlib
import copy
import os
import subprocess
import tempfile
import threading

from ._controller import check
from ._declare import declaration
from ._parameter import _number, parameters_of, quoted
from ._serve import converse


class Served:
    """A class, or an object of one, that drives vehicles of these names."""

    def __init__(self, controller, vehicles):
        self.controller = controller if isinstance(controller, type) else type(controller)
        check(self.controller)
        self.vehicles = vehicles
        # Each run begins with what the object is now.
        self.make = None if isinstance(controller, type) else lambda: copy.deepcopy(controller)
        own = () if self.make is None else vars(controller)
        given = (one for one in parameters_of(self.controller) if one.name in own)
        self.settings = ", ".join(f"{one.name}: {_value(own[one.name], one)}" for one in given)

    @property
    def name(self):
        """As the runner calls it."""
        return self.controller.own_name()

    def words(self):
        """What the runner is told."""
        settings = f" {{ {self.settings} }}" if self.settings else ""
        return [f"--serve-by-parent={self.name}", *(f"--controller={vehicle}={self.name}{settings}" for vehicle in self.vehicles)]

    @contextlib.contextmanager
    def declared(self):
        """A file that declares the class."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, f"{self.name}.scn")
            with open(path, "w", encoding="utf-8") as file:
                # Nobody runs it: who asks for a decision is answered here.
                file.write(declaration(self.controller, ["parent"]) + "\n")
            yield path

    def run(self, command):
        """Runs the runner and answers it; its exit code and what it said."""
        runner = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        said = []
        # What nobody reads would hold the runner.
        reader = threading.Thread(target=lambda: said.append(runner.stderr.read()), daemon=True)
        reader.start()
        try:
            with contextlib.suppress(BrokenPipeError):
                converse(self.controller, runner.stdout, runner.stdin, make=self.make, is_parent=True)
            with contextlib.suppress(BrokenPipeError):
                runner.stdin.close()
            # Whatever it still says goes nowhere, and holds nobody.
            while runner.stdout.read(1 << 16):
                pass
            runner.wait()
        finally:
            if runner.poll() is None:
                # It takes the end of its streams for ours, writes its reports and ends.
                with contextlib.suppress(BrokenPipeError):
                    runner.stdin.close()
                runner.stdout.close()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    runner.wait(timeout=10)
            if runner.poll() is None:
                runner.kill()
                runner.wait()
            reader.join()
            for stream in (runner.stdout, runner.stderr):
                stream.close()
        return runner.returncode, b"".join(said).decode("utf-8", errors="replace")


def served(controllers):
    """What is served among what is to drive vehicles, or None, and the words for the rest."""
    words, objects = [], {}
    for vehicle, controller in controllers.items():
        if isinstance(controller, str):
            words.append(f"--controller={vehicle}={controller}")
        else:
            objects.setdefault(id(controller), (controller, []))[1].append(vehicle)
    if len(objects) > 1:
        raise ValueError("one class or object drives in a run; name others as the files declare them: `other=\"my_other\"`")
    return next((Served(*one) for one in objects.values()), None), words


def _value(value, of):
    if of.kind == "flag":
        return "true" if value else "false"
    if of.kind in ("number", "whole"):
        return _number(value, of.unit)
    return str(value) if of.kind == "word" else quoted(value)
