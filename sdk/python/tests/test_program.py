"""Programs as the runner starts them: what they print, and what `--declare` says."""

import json
import os
import subprocess
import sys
import tempfile
import textwrap
import unittest

from conversation import COLUMNS
from scenario_runner_av import Controller, parameter
from scenario_runner_av._controller import check

PROGRAM = """
    import os, sys
    from scenario_runner_av import Controller, parameter, serve

    class MyAv(Controller):
        '''Brakes for "whoever" crosses.

        And more.'''
        gives, period = "acceleration", 0.1
        braking_distance = parameter(5.0, "m", low=1, high=30, doc="Gap kept.")
        horizon = parameter(20, low=5, high=80)
        profile = parameter("normal", options=["cautious", "normal"])
        yields = parameter(True)
        weights = parameter("v3.onnx")

        def start(self, run):
            print("starting")
            os.system("echo from a child")
            sys.stdin.read()

        def step(self, seen):
            return 0

    print("imported")
    if __name__ == "__main__":
        serve(MyAv)
"""

DECLARATION = """\
controller my_av {
  "Brakes for \\"whoever\\" crosses."
  command "python3", "my_av.py"
  gives acceleration
  period 100 ms
  parameter braking_distance = 5 m in 1 m .. 30 m "Gap kept."
  parameter horizon = 20 in whole 5 .. 80
  parameter profile = normal in [cautious, normal]
  parameter yields = true
  parameter weights = "v3.onnx"
}
"""


class Programs(unittest.TestCase):
    def run_program(self, arguments, text="", **environment):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "my_av.py"), "w") as file:
                file.write(textwrap.dedent(PROGRAM))
            return subprocess.run(
                [sys.executable, *arguments],
                cwd=folder,
                env={**os.environ, **environment},
                input=text,
                capture_output=True,
                text=True,
                timeout=60,
            )

    def test_the_declaration(self):
        ran = self.run_program(["my_av.py", "--declare"])
        self.assertEqual((ran.stdout, ran.stderr), ("imported\n" + DECLARATION, ""))
        ran = self.run_program(["-m", "my_av", "--declare"])
        self.assertIn('command "python3", "-m", "my_av"\n', ran.stdout)

    def test_prints_never_get_between_runner_and_program(self):
        hello = {"hello": {"protocol": 1, "columns": COLUMNS}}
        opened = {"open": [{"slot": 0, "parameters": {}}]}
        text = "".join(json.dumps(one) + "\n" for one in (hello, opened, {"bye": {}}))
        ran = self.run_program(["my_av.py", "--encoding=json"], text, SCENARIO_RUNNER_CONTROLLER="my_av")
        said = [json.loads(line) for line in ran.stdout.splitlines()]
        self.assertEqual((list(said[0]), said[1]), (["hello"], {"ready": [0]}))
        self.assertEqual(sorted(ran.stderr.splitlines()), ["from a child", "imported", "starting"])
        self.assertEqual(ran.returncode, 0)

    def test_without_a_runner_what_is_printed_at_import_is_printed(self):
        self.assertEqual(self.run_program(["-c", "import my_av; print('here')"]).stdout, "imported\nhere\n")


class Declarations(unittest.TestCase):
    def test_what_no_file_could_declare_is_refused(self):
        for wrong in (
            lambda: parameter(5.0, "m"),
            lambda: parameter(5.0, "m", low=6, high=30),
            lambda: parameter(5.0, "km", low=1, high=30),
            lambda: parameter(float("nan"), "m", low=1, high=30),
            lambda: parameter(5, "", low=1, high=float("inf")),
            lambda: parameter("fast", options=["slow"]),
            lambda: parameter("v3", options=["v3", "a b"]),
            lambda: parameter(True, low=0, high=1),
            lambda: parameter(None),
        ):
            with self.assertRaises((TypeError, ValueError)):
                wrong()

    def test_a_whole_number_with_a_unit_is_a_number(self):
        self.assertEqual(parameter(5, "m", low=1, high=30).kind, "number")
        self.assertEqual(parameter(5, low=1, high=30).kind, "whole")
        self.assertEqual(parameter(5, low=1, high=30.5).kind, "number")

    def test_classes_that_no_runner_takes_are_refused(self):
        def of(**attributes):
            return type("Own", (Controller,), attributes)

        check(of())
        for wrong in (of(gives="torque"), of(runs_at_once=0), of(runs_at_once=2000), of(modes="cruise"), of(mode=parameter(True))):
            with self.assertRaises((TypeError, ValueError)):
                check(wrong)
        with self.assertRaises(TypeError):
            check(object())

    def test_names_of_classes(self):
        self.assertEqual(type("MyAv2", (Controller,), {}).own_name(), "my_av2")
        self.assertEqual(type("Own", (Controller,), {"name": "planner"}).own_name(), "planner")

    def test_parameters_of_bases_are_inherited_and_may_be_taken_away(self):
        from scenario_runner_av._parameter import parameters_of

        base = type("Base", (Controller,), {"gap": parameter(5.0, "m", low=1, high=9), "calm": parameter(True)})
        own = type("Own", (base,), {"calm": False, "gap": parameter(6.0, "m", low=1, high=9)})
        self.assertEqual([(one.name, one.default) for one in parameters_of(own)], [("gap", 6.0)])


if __name__ == "__main__":
    unittest.main()
