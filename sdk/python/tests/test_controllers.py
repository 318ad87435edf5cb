"""Controllers of one run and of many, in both encodings."""

import contextlib
import io
import math
import unittest

from conversation import COLUMNS, run, scene, talk
from scenario_runner_av import ESCOOTER, PEDESTRIAN, Controller, VectorController, parameter


class Brake(Controller):
    """Brakes for whoever is near."""

    modes = ("cruise", "brake")
    gap = parameter(20.0, "m", low=1, high=30)

    def step(self, seen):
        near = any(0 < one.x < self.gap for one in seen.pedestrians)
        self.mode = "brake" if near else "cruise"
        return -3.0 if near else seen.cruise_speed - seen.speed


def opened(*slots, **parameters):
    return {"open": [run(slot, **parameters) for slot in slots]}


SCENES = {"step": [scene(3, people=[(50.0, 0.0), (10.0, 1.0)]), scene(1), scene(0, 7.5, [(-4.0, 0.0)])]}


class Conversation(unittest.TestCase):
    def test_both_encodings_say_the_same(self):
        hello, answers = talk(Brake, [opened(0, 1, 3, gap=20.0), SCENES])
        self.assertEqual((hello["protocol"], hello["name"], hello["encoding"], hello["gives"]), (1, "brake", "json", ["acceleration"]))
        self.assertEqual(hello["parameters"], [{"name": "gap", "default": 20.0, "unit": "m", "low": 1, "high": 30}])
        said = [{"acceleration": -3.0, "mode": "brake"}, {"acceleration": 3.0, "mode": "cruise"}, {"acceleration": 0.5, "mode": "cruise"}]
        self.assertEqual(answers, [{"ready": [0, 1, 3]}, {"answer": said}])
        hello, answers = talk(Brake, [opened(0, 1, 3, gap=20.0), SCENES], "f64")
        self.assertEqual(hello["encoding"], "f64")
        self.assertEqual(answers, [{"ready": [0, 1, 3]}, [[-3.0, 1.0], [3.0, 0.0], [0.5, 0.0]]])

    def test_parameters_are_those_of_the_run(self):
        _, answers = talk(Brake, [{"open": [run(0, gap=5.0), run(1, gap=20.0)]}, {"step": [scene(slot, people=[(10.0, 0.0)]) for slot in (0, 1)]}])
        self.assertEqual([one["acceleration"] for one in answers[1]["answer"]], [3.0, -3.0])
        self.assertEqual(Brake().gap, 20.0)

    def test_columns_that_are_not_known_are_left_out(self):
        more = {name: ["later", *reversed(known), "still_later"] for name, known in COLUMNS.items()}
        for encoding in ("f64", "json"):
            known, other = (talk(Brake, [opened(0, 1, 3, gap=20.0), SCENES], encoding, columns=columns)[1] for columns in (COLUMNS, more))
            self.assertEqual(known, other)

    def test_what_is_seen(self):
        seen = []

        class Looks(Controller):
            def start(self, run):
                seen.append(run)

            def step(self, scene):
                seen.append(scene)
                return 0

        for encoding in ("f64", "json"):
            seen.clear()
            talk(Looks, [opened(2), {"step": [scene(2, 5.5, [(1.0, 2.0)], signal=False), scene(2)]}], encoding)
            run_, first, second = seen
            self.assertEqual((run_.slot, run_.road.crossing, run_.road.boxes[0].length), (2, "zebra", 3.0))
            self.assertEqual((first.slot, first.speed, first.new, first.pedestrian_priority), (2, 5.5, False, True))
            self.assertIs(first.signal, False)
            self.assertIsNone(second.signal)
            self.assertEqual((first.pedestrians[0].y, first.vehicles[0].vx, first.left_kerb), (2.0, -8.0, 2.0))
            self.assertEqual(second.pedestrians, [])

    def test_a_lane_that_bends_is_told(self):
        seen = []

        class Looks(Controller):
            def step(self, scene):
                seen.append(scene)
                return 0

        bent = {"step": [scene(0), scene(1, bends=[(20.0, 0.0), (45.0, 0.02)])]}
        opening = {"open": [run(0), run(1)]}
        older = {table: names for table, names in COLUMNS.items() if table not in ("lanes", "curvature_ahead", "kinds", "crossings")}
        for encoding, columns in (("f64", COLUMNS), ("json", COLUMNS), ("f64", older)):
            seen.clear()
            hello, _ = talk(Looks, [opening, bent], encoding, 2, columns)
            self.assertEqual(hello["tables"], ["lanes", "kinds", "crossings"])
            plain, one = seen
            if columns is older:
                self.assertTrue(all(math.isnan(value) for value in (plain.travelled, plain.curvature, plain.gradient)))
                self.assertEqual((plain.vehicles[0].x, one.curvature_ahead, one.crossings), (9.0, [], []))
                continue
            self.assertEqual((plain.travelled, plain.curvature, plain.gradient != plain.gradient), (-30.0, 0.0, True))
            self.assertEqual((plain.curvature_ahead, one.curvature), ([], 0.25))
            self.assertEqual([tuple(change) for change in one.curvature_ahead], [(1, 20.0, 0.0), (1, 45.0, 0.02)], encoding)

    def test_who_rides_and_every_crossing_is_told(self):
        seen = []

        class Looks(Controller):
            def step(self, scene):
                seen.append(scene)
                return 0

        plain, several = scene(0, people=[(5.0, 1.0)]), scene(1, people=[(5.0, 1.0), (9.0, 0.0)])
        several["pedestrians"][1]["kind"] = "escooter"
        near = {"distance": -4.0, "width": 3.0, "pedestrian_priority": True, "right_edge": -2.0, "left_edge": 1.5}
        several["road"]["crossings"] = [near, {**near, "distance": 20.0, "pedestrian_priority": False}]
        older = {table: names for table, names in COLUMNS.items() if table not in ("kinds", "crossings")}
        for encoding, columns in (("f64", COLUMNS), ("json", COLUMNS), ("f64", older)):
            seen.clear()
            talk(Looks, [{"open": [run(0), run(1)]}, {"step": [plain, several]}], encoding, 2, columns)
            one, two = seen
            known = columns is COLUMNS
            self.assertEqual([who.kind for who in one.pedestrians + two.pedestrians], [PEDESTRIAN, PEDESTRIAN, ESCOOTER if known else PEDESTRIAN])
            told = [tuple(crossing) for crossing in one.crossings + two.crossings]
            wanted = [(0, 30.0, 4.0, True, -2.0, 2.0), (1, -4.0, 3.0, True, -2.0, 1.5), (1, 20.0, 3.0, False, -2.0, 1.5)]
            self.assertEqual(told, wanted if known else [], encoding)

    def test_a_curvature_is_an_answer_where_the_runner_takes_one(self):
        class Steers(Controller):
            def step(self, seen):
                self.curvature = -0.1 * seen.lateral_offset if seen.lateral_offset else None
                return seen.heading_error

        beside, on_it = scene(0), scene(0, time=1.1)
        beside["ego"].update(lateral_offset=2.0, heading_error=0.02)
        requests = [opened(0), {"step": [beside]}, {"step": [on_it]}]
        _, (_, *answers) = talk(Steers, requests)
        self.assertEqual(answers, [{"answer": [{"acceleration": 0.02, "curvature": -0.2}]}, {"answer": [{"acceleration": 0.0}]}])
        _, (_, (first,), (second,)) = talk(Steers, requests, "f64")
        self.assertEqual((first, second), ([0.02, -1.0, -0.2], [0.0, -1.0]))

        class Always(Steers):
            def step(self, seen):
                self.curvature = 0.1
                return 0

        older = {**COLUMNS, "lanes": COLUMNS["lanes"][:-2]}
        with contextlib.redirect_stderr(io.StringIO()):
            _, (_, refused) = talk(Always, requests[:2], columns=older)
        self.assertEqual(refused, {"error": [{"slot": 0, "message": "ValueError: this runner takes no curvature"}]})

    def test_a_slot_is_used_again_by_another_instance(self):
        class Counts(Controller):
            steps = 0

            def step(self, seen):
                self.steps += 1
                return self.steps

        step = {"step": [scene(0)]}
        close = {"close": [{"slot": 0, "reason": "completed"}]}
        _, answers = talk(Counts, [opened(0), step, step, close, opened(0), step])
        self.assertEqual([one["answer"][0]["acceleration"] for one in answers if "answer" in one], [1.0, 2.0, 1.0])

    def test_an_exception_is_an_error_of_its_run_and_nobody_decides_twice(self):
        class Fails(Controller):
            steps = 0

            def step(self, seen):
                if seen.slot == 1:
                    raise ValueError('lane is "None"')
                self.steps += 1
                return self.steps

        asked = [scene(0), scene(1), scene(2)]
        again = [scene(0), scene(2)]
        later = [scene(0, time=1.1), scene(2, time=1.1)]
        for encoding in ("json", "f64"):
            with contextlib.redirect_stderr(io.StringIO()) as log:
                _, answers = talk(Fails, [opened(0, 1, 2), {"step": asked}, {"step": again}, {"step": later}], encoding)
            self.assertIn("Traceback", log.getvalue())
            self.assertIn("raise ValueError", log.getvalue())
            self.assertEqual(answers[1], {"error": [{"slot": 1, "message": 'ValueError: lane is "None"'}]})
            values = [row[0] for row in answers[2] + answers[3]] if encoding == "f64" else [
                one["acceleration"] for answer in answers[2:] for one in answer["answer"]
            ]
            self.assertEqual(values, [1.0, 1.0, 2.0, 2.0])

    def test_what_cannot_begin_is_refused(self):
        class Fails(Controller):
            def start(self, run):
                if run.slot == 1:
                    raise OSError("no such weights")

        with contextlib.redirect_stderr(io.StringIO()):
            _, answers = talk(Fails, [opened(0, 1)])
        self.assertEqual(answers, [{"ready": [0], "failed": [{"slot": 1, "message": "OSError: no such weights"}]}])

    def test_what_is_no_number_is_an_error_and_what_is_not_finite_the_runners_to_refuse(self):
        for value, kind in ((None, "TypeError"), ((1, 2), "TypeError"), ("fast", "is not a number"), (True, "is not a number"), ("1", "is not a number")):
            class Gives(Controller):
                def step(self, seen):
                    return value

            with contextlib.redirect_stderr(io.StringIO()):
                _, answers = talk(Gives, [opened(0), {"step": [scene(0)]}], "f64")
            self.assertIn(kind, answers[1]["error"][0]["message"])

        class NotFinite(Controller):
            def step(self, seen):
                return math.nan

        self.assertEqual(talk(NotFinite, [opened(0), {"step": [scene(0)]}])[1][1], {"answer": [{"acceleration": None}]})
        self.assertTrue(math.isnan(talk(NotFinite, [opened(0), {"step": [scene(0)]}], "f64")[1][1][0][0]))

    def test_an_exit_is_an_error_of_its_run(self):
        class Ends(Controller):
            def start(self, run):
                if run.slot == 1:
                    raise SystemExit(0)

            def step(self, seen):
                raise SystemExit(0)

        for encoding in ("f64", "json"):
            with contextlib.redirect_stderr(io.StringIO()):
                _, answers = talk(Ends, [opened(0, 1), {"step": [scene(0)]}], encoding)
            self.assertEqual(answers[0], {"ready": [0], "failed": [{"slot": 1, "message": "SystemExit: 0"}]})
            self.assertEqual(answers[1], {"error": [{"slot": 0, "message": "SystemExit: 0"}]})

    def test_only_an_interruption_by_the_user_passes_through(self):
        class Interrupted(Controller):
            def step(self, seen):
                raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt), contextlib.redirect_stderr(io.StringIO()):
            talk(Interrupted, [opened(0), {"step": [scene(0)]}])

    def test_a_mode_that_was_not_announced_is_an_error(self):
        class Sleeps(Controller):
            modes = ("cruise",)

            def step(self, seen):
                self.mode = "sleep"
                return 0

        with contextlib.redirect_stderr(io.StringIO()):
            _, answers = talk(Sleeps, [opened(0), {"step": [scene(0)]}])
        self.assertIn("'sleep' is none of `modes`", answers[1]["error"][0]["message"])

    def test_everything_that_may_be_given(self):
        for gives, value, text, row in (
            ("pedals", (0.25, 0), {"throttle": 0.25, "brake": 0.0}, [0.25, 0.0]),
            ("speed", 4, {"speed": 4.0}, [4.0]),
            ("speed_plan", [(1, 5), (2, 6)], {"speed_plan": [[1.0, 5.0], [2.0, 6.0]]}, [1.0, 5.0, 2.0, 6.0]),
        ):
            class Drives(Controller):
                def step(self, seen):
                    return value

            Drives.gives = gives
            self.assertEqual(talk(Drives, [opened(0), {"step": [scene(0)]}])[1][1], {"answer": [text]})
            given = talk(Drives, [opened(0), {"step": [scene(0)]}], "f64")[1][1][0]
            self.assertEqual(len(given), 33 if gives == "speed_plan" else len(row) + 1)
            self.assertEqual((given[: len(row)], given[-1]), (row, -1.0))
            self.assertTrue(all(map(math.isnan, given[len(row) : -1])))

    def test_another_protocol_is_not_spoken(self):
        self.assertEqual(talk(Brake, [{"bye": {}}, opened(0)])[1], [])


class VectorBrake(VectorController):
    modes = ("cruise", "brake")
    gap = parameter(20.0, "m", low=1, high=30)

    def step(self, batch):
        people = batch.pedestrians
        near = people.any((0 < people.x) & (people.x < self.gap[batch.slot][people.row]))
        batch.mode = near * 1
        return [-3.0 if one else wanted - speed for one, wanted, speed in zip(near, batch.cruise_speed, batch.speed)]


class Vectors(unittest.TestCase):
    def test_arrays_decide_as_objects_do(self):
        requests = [{"open": [run(0, gap=20.0), run(1, gap=5.0), run(3, gap=20.0)]}, SCENES, {"step": [scene(1, people=[(10.0, 0.0)])]}]
        for encoding in ("json", "f64"):
            self.assertEqual(talk(VectorBrake, requests, encoding)[1], talk(Brake, requests, encoding)[1])

    def test_a_lane_that_bends_is_told_in_arrays(self):
        told = []

        class Looks(VectorController):
            def step(self, batch):
                ahead = batch.curvature_ahead
                told.append((batch.curvature.tolist(), ahead.row.tolist(), ahead.distance.tolist(), ahead.curvature.tolist()))
                return ahead.least(ahead.distance, 0.0)

        bent = {"step": [scene(0), scene(1, bends=[(20.0, 0.0), (45.0, 0.02)])]}
        for encoding in ("f64", "json"):
            talk(Looks, [{"open": [run(0), run(1)]}, bent], encoding, 2)
            self.assertEqual(told.pop(), ([0.0, 0.25], [1, 1], [20.0, 45.0], [0.0, 0.02]))

    def test_reductions_are_of_ones_own_people(self):
        found = []

        class Looks(VectorController):
            def step(self, batch):
                found.append((list(batch.pedestrians.least(batch.pedestrians.x)), list(batch.pedestrians.any(batch.pedestrians.y > 0.5))))
                return batch.speed

        talk(Looks, [opened(0, 1, 3), SCENES])
        self.assertEqual(found, [([10.0, math.inf, -4.0], [True, False, False])])

    def test_an_exception_with_many_runs_ends_the_process_and_with_one_is_its_error(self):
        class Fails(VectorController):
            def step(self, batch):
                raise ValueError("no lane")

        with self.assertRaises(ValueError):
            talk(Fails, [opened(0, 1), {"step": [scene(0), scene(1)]}])
        with contextlib.redirect_stderr(io.StringIO()):
            _, answers = talk(Fails, [opened(0), {"step": [scene(0)]}])
        self.assertEqual(answers[1], {"error": [{"slot": 0, "message": "ValueError: no lane"}]})

    def test_a_wrong_shape_is_an_error(self):
        class Short(VectorController):
            def step(self, batch):
                return 1.0

        with self.assertRaisesRegex(ValueError, "shape"):
            talk(Short, [opened(0, 1), {"step": [scene(0), scene(1)]}], "f64")

    def test_an_array_of_flags_or_texts_is_an_error(self):
        for row in ([True, False], ["1", "2"]):

            class Other(VectorController):
                def step(self, batch):
                    return row

            with self.assertRaisesRegex(TypeError, "where numbers were due"):
                talk(Other, [opened(0, 1), {"step": [scene(0), scene(1)]}], "f64")

    def test_plans_may_be_shorter(self):
        class Plans(VectorController):
            gives = "speed_plan"

            def step(self, batch):
                return [[1.0, 5.0, 2.0, 6.0]]

        self.assertEqual(talk(Plans, [opened(0), {"step": [scene(0)]}])[1][1], {"answer": [{"speed_plan": [[1.0, 5.0], [2.0, 6.0]]}]})


if __name__ == "__main__":
    unittest.main()
