"""Reads JUnit reports the way CI servers do and fails on anything that they would stumble over."""

import sys

import xmlschema
from junitparser import Error, Failure, JUnitXml, Properties


def check(schema, path):
    schema.validate(path)
    report = JUnitXml.fromfile(path)
    names = set()
    failures = 0
    for suite in report:
        cases = list(suite)
        assert suite.tests == len(cases), f"{path}: {suite.name} counts {suite.tests} tests but has {len(cases)}"
        for case in cases:
            name = (case.classname, case.name)
            assert name not in names, f"{path}: {name} stands there twice, and GitLab would drop one"
            names.add(name)
            properties = {prop.name: prop.value for prop in case.child(Properties)}
            for needed in ("seed", "runs", "replay", "pet"):
                assert needed in properties, f"{path}: {case.name} has no property {needed}"
            for result in case.result:
                if isinstance(result, (Failure, Error)):
                    failures += 1
                    assert result.message and result.text, f"{path}: {case.name} fails without a reason"
                    assert "replay" in result.text, f"{path}: {case.name} does not say how to replay it"
    assert names, f"{path}: no test case"
    return len(names), failures


def main(schema_path, *paths):
    schema = xmlschema.XMLSchema(schema_path)
    for path in paths:
        cases, failures = check(schema, path)
        print(f"{path}: {cases} test cases, {failures} failures, valid")
        assert ("unsafe" in path) == (failures > 0), f"{path}: {failures} failures"


if __name__ == "__main__":
    main(*sys.argv[1:])
