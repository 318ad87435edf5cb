"""What the front door offers to Rust programs, a line each, from the documentation of all packages as data.

Whatever such a line says, somebody may rely on: a line that is gone or says something else may break a program, a line more breaks none.
So what may grow without breaking anybody has a line for each part (fields of a struct that has private ones, variants of an enum that is
`non_exhaustive`, provided methods), and what may not stands in one line as a whole.
"""

import json
import pathlib
import sys

FRONT = "scenario_runner"
# The layout of the data that is read here; another one is looked at before it is believed.
LAYOUT = 57
# What the compiler says of types for itself, and what hardly anybody asks of one; `Send` and `Sync` are told.
UNNAMED = {"Freeze", "RefUnwindSafe", "StructuralPartialEq", "Unpin", "UnsafeUnpin", "UnwindSafe"}


class Unread(Exception):
    """Something stands in the data that is not understood, so that nothing can be said."""


class Package:
    def __init__(self, path):
        data = json.loads(path.read_text())
        if data["format_version"] != LAYOUT:
            raise Unread(f"{path.name} has layout {data['format_version']} of rustdoc's data, and this reads {LAYOUT}")
        self.items, self.paths, self.root = data["index"], data["paths"], data["root"]
        self.version = data["crate_version"]
        self.places = {tuple(one["path"]): id for id, one in self.paths.items() if one["crate_id"] == 0}

    def item(self, id):
        return self.items.get(str(id))


def kind(item):
    (word, inner), = item["inner"].items()
    return word, inner


def last(path):
    return path.rsplit("::", 1)[-1]


def named(path):
    return last(path["path"]) + arguments(path["args"])


def arguments(args):
    if args is None or args == "return_type_notation":
        return ""
    if "parenthesized" in args:
        inside = args["parenthesized"]
        return f"({', '.join(map(typed, inside['inputs']))}){returned(inside['output'])}"
    inside = args["angle_bracketed"]
    parts = [argument(one) for one in inside["args"]] + [constraint(one) for one in inside["constraints"]]
    return f"<{', '.join(parts)}>" if parts else ""


def argument(one):
    if one == "infer":
        return "_"
    (word, inner), = one.items()
    return {"lifetime": str, "type": typed, "const": lambda const: const["expr"]}[word](inner)


def constraint(one):
    (word, inner), = one["binding"].items()
    if word == "equality":
        return f"{one['name']} = {term(inner)}"
    return f"{one['name']}: {bounded(inner)}"


def term(one):
    return typed(one["type"]) if "type" in one else one["constant"]["expr"]


def returned(output):
    return "" if output is None else f" -> {typed(output)}"


def typed(one):
    if one == "infer":
        return "_"
    (word, inner), = one.items()
    match word:
        case "resolved_path":
            return named(inner)
        case "generic" | "primitive":
            return inner
        case "tuple":
            return f"({', '.join(map(typed, inner))})"
        case "slice":
            return f"[{typed(inner)}]"
        case "array":
            return f"[{typed(inner['type'])}; {inner['len']}]"
        case "impl_trait":
            return f"impl {bounded(inner)}"
        case "dyn_trait":
            traits = [binder(one["generic_params"]) + named(one["trait"]) for one in inner["traits"]]
            return "dyn " + " + ".join(traits + [inner["lifetime"]] * bool(inner["lifetime"]))
        case "raw_pointer":
            return f"*{'mut' if inner['is_mutable'] else 'const'} {typed(inner['type'])}"
        case "borrowed_ref":
            lifetime = f"{inner['lifetime']} " if inner["lifetime"] else ""
            return f"&{lifetime}{'mut ' if inner['is_mutable'] else ''}{typed(inner['type'])}"
        case "function_pointer":
            inputs = ", ".join(typed(one) for _, one in inner["sig"]["inputs"])
            return f"{binder(inner['generic_params'])}{header(inner['header'])}fn({inputs}){returned(inner['sig']['output'])}"
        case "qualified_path":
            whose = f" as {named(inner['trait'])}" if inner["trait"] else ""
            return f"<{typed(inner['self_type'])}{whose}>::{inner['name']}{arguments(inner['args'])}"
    raise Unread(f"a type is a `{word}`")


def bounded(bounds):
    def bound(one):
        (word, inner), = one.items()
        match word:
            case "outlives":
                return inner
            case "trait_bound":
                mark = {"none": "", "maybe": "?", "maybe_const": "~const "}[inner["modifier"]]
                return binder(inner["generic_params"]) + mark + named(inner["trait"])
            case "use":
                return f"use<{', '.join(next(iter(one.values())) for one in inner)}>"
        raise Unread(f"a bound is a `{word}`")

    return " + ".join(map(bound, bounds))


def binder(parameters):
    return f"for<{', '.join(one['name'] for one in parameters)}> " if parameters else ""


def generic(generics):
    def parameter(one):
        (word, inner), = one["kind"].items()
        match word:
            case "lifetime":
                return one["name"] + (f": {' + '.join(inner['outlives'])}" if inner["outlives"] else "")
            case "type":
                default = f" = {typed(inner['default'])}" if inner["default"] else ""
                return one["name"] + (f": {bounded(inner['bounds'])}" if inner["bounds"] else "") + default
            case "const":
                return f"const {one['name']}: {typed(inner['type'])}"
        raise Unread(f"a parameter is a `{word}`")

    def predicate(one):
        (word, inner), = one.items()
        match word:
            case "bound_predicate":
                return f"{binder(inner['generic_params'])}{typed(inner['type'])}: {bounded(inner['bounds'])}"
            case "lifetime_predicate":
                return f"{inner['lifetime']}: {' + '.join(inner['outlives'])}"
            case "eq_predicate":
                return f"{typed(inner['lhs'])} = {term(inner['rhs'])}"
        raise Unread(f"a condition is a `{word}`")

    # What stands for `impl Trait` among the inputs is told there.
    parameters = [parameter(one) for one in generics["params"] if not is_synthetic(one)]
    where = [predicate(one) for one in generics["where_predicates"]]
    return (f"<{', '.join(parameters)}>" if parameters else ""), (f" where {', '.join(where)}" if where else "")


def is_synthetic(parameter):
    return parameter["kind"].get("type", {}).get("is_synthetic", False)


def header(one):
    words = [word for word in ("const", "async", "unsafe") if one[f"is_{word}"]]
    if one["abi"] != "Rust":
        words.append(f"extern {json.dumps(one['abi'])}")
    return "".join(f"{word} " for word in words)


def function(name, inner):
    parameters, where = generic(inner["generics"])
    inputs = ", ".join(typed(one) for _, one in inner["sig"]["inputs"])
    return f"{header(inner['header'])}fn {name}{parameters}({inputs}){returned(inner['sig']['output'])}{where}"


def open_ended(item):
    return any("non_exhaustive" in json.dumps(one) for one in item["attrs"])


class Door:
    def __init__(self, folder):
        self.packages = {path.stem: Package(path) for path in sorted(folder.glob(f"{FRONT}*.json"))}
        self.lines = set()
        self.version = self.packages[FRONT].version
        front = self.packages[FRONT]
        self.module(front, front.item(front.root), FRONT)

    def say(self, line):
        self.lines.add(" ".join(line.split()))

    def module(self, package, module, path):
        for id in module["inner"]["module"]["items"]:
            item = package.item(id)
            if item is None:
                raise Unread(f"an item of {path} is not in the data")
            if item["visibility"] == "public":
                self.offered(package, item, path)

    def offered(self, package, item, path):
        """What a module offers by a name of its own."""
        word, inner = kind(item)
        if word != "use":
            return self.item(package, item, f"{path}::{item['name']}")
        target = package.item(inner["id"])
        if target is None:
            known = package.paths.get(str(inner["id"]))
            owner = self.packages.get(known["path"][0]) if known else None
            if owner is None:
                # Somebody else's: its name is all that is ours.
                return self.say(f"use {path}::{inner['name']} = {inner['source']}")
            package = owner
            id = package.root if len(known["path"]) == 1 else package.places.get(tuple(known["path"]))
            target = package.item(id)
            if target is None:
                raise Unread(f"{'::'.join(known['path'])} is not in the data")
        if inner["is_glob"]:
            word, of = kind(target)
            if word == "module":
                return self.module(package, target, path)
            raise Unread(f"{path} re-exports all of a {word}")
        if kind(target)[0] == "use":
            return self.offered(package, dict(target, name=inner["name"]), path)
        self.item(package, target, f"{path}::{inner['name']}")

    def item(self, package, item, path):
        word, inner = kind(item)
        match word:
            case "module":
                self.say(f"mod {path}")
                self.module(package, item, path)
            case "function":
                self.say(function(path, inner))
            case "constant":
                self.say(f"const {path}: {typed(inner['type'])}")
            case "static":
                self.say(f"static {'mut ' if inner['is_mutable'] else ''}{path}: {typed(inner['type'])}")
            case "type_alias":
                parameters, where = generic(inner["generics"])
                self.say(f"type {path}{parameters}{where} = {typed(inner['type'])}")
            case "macro":
                self.say(f"macro {path}!")
            case "struct":
                self.struct(package, item, inner, path)
            case "enum":
                self.enum(package, item, inner, path)
            case "trait":
                self.trait(package, inner, path)
            case _:
                raise Unread(f"{path} is a {word}")

    def fields(self, package, kinds):
        """Name and type of the public ones, in order, and whether these are all."""
        if kinds in ("unit", "plain"):
            return None, True
        (word, inner), = kinds.items()
        if word == "tuple":
            all_of_them = inner
            hidden = None in inner
        else:
            all_of_them, hidden = inner["fields"], inner["has_stripped_fields"]
        found = []
        for id in all_of_them:
            item = package.item(id) if id is not None else None
            if item is not None:
                found.append((item["name"], typed(kind(item)[1])))
        return (word, found), not hidden

    def shape(self, fields):
        if fields is None:
            return ""
        word, parts = fields
        if word == "tuple":
            return f"({', '.join(of for _, of in parts)})"
        return " { " + ", ".join(f"{name}: {of}" for name, of in parts) + " }"

    def struct(self, package, item, inner, path):
        parameters, where = generic(inner["generics"])
        fields, complete = self.fields(package, inner["kind"])
        if complete and not open_ended(item):
            self.say(f"struct {path}{parameters}{where}{self.shape(fields)}")
        else:
            self.say(f"struct {path}{parameters}{where} {{ .. }}")
            for name, of in fields[1] if fields else []:
                self.say(f"field {path}.{name}: {of}")
        self.impls(package, inner["impls"], path)

    def enum(self, package, item, inner, path):
        parameters, where = generic(inner["generics"])
        variants = []
        for id in inner["variants"]:
            variant = package.item(id)
            fields, complete = self.fields(package, kind(variant)[1]["kind"])
            more = "" if complete and not open_ended(variant) else " .."
            variants.append(f"{variant['name']}{self.shape(fields)}{more}")
        if open_ended(item):
            self.say(f"enum {path}{parameters}{where} {{ .. }}")
            for variant in variants:
                self.say(f"variant {path}::{variant}")
        else:
            self.say(f"enum {path}{parameters}{where} {{ {', '.join(variants)} }}")
        self.impls(package, inner["impls"], path)

    def part(self, package, id, path):
        """A method, constant or type of a trait or an impl, and whether whoever implements it has to give it."""
        item = package.item(id)
        word, inner = kind(item)
        name = f"{path}::{item['name']}"
        match word:
            case "function":
                return function(name, inner), not inner["has_body"]
            case "assoc_const":
                return f"const {name}: {typed(inner['type'])}", inner["value"] is None
            case "assoc_type":
                parameters, where = generic(inner["generics"])
                bounds = f": {bounded(inner['bounds'])}" if inner["bounds"] else ""
                given = f" = {typed(inner['type'])}" if inner["type"] else ""
                return f"type {name}{parameters}{bounds}{where}{given}", inner["type"] is None
        raise Unread(f"{name} is a {word}")

    def trait(self, package, inner, path):
        parameters, where = generic(inner["generics"])
        parts = [(self.part(package, id, path), package.item(id)["name"]) for id in inner["items"]]
        needed = ", ".join(name for (_, needs), name in parts if needs)
        bounds = f": {bounded(inner['bounds'])}" if inner["bounds"] else ""
        safe = "" if inner["is_dyn_compatible"] else " not dyn"
        self.say(f"{'unsafe ' * inner['is_unsafe']}trait {path}{parameters}{bounds}{where} {{ {needed} }}{safe}")
        for (line, _), _ in parts:
            self.say(line)

    def impls(self, package, ids, path):
        for id in ids:
            item = package.item(id)
            if item is None:
                continue
            _, inner = kind(item)
            if inner["blanket_impl"] is not None or inner["is_negative"]:
                continue
            parameters, where = generic(inner["generics"])
            if inner["trait"] is None:
                whose = f" of impl{parameters} {typed(inner['for'])}{where}" if parameters or where else ""
                for id in inner["items"]:
                    part = package.item(id)
                    if part is not None and part["visibility"] == "public":
                        self.say(self.part(package, id, path)[0] + whose)
            elif last(inner["trait"]["path"]) not in UNNAMED:
                self.say(f"impl{parameters} {named(inner['trait'])} for {path}{where}")


def main(folder, recorded, accept):
    try:
        door = Door(pathlib.Path(folder))
    except (Unread, KeyError, ValueError, TypeError) as problem:
        sys.exit(f"the front door cannot be read: {problem!r}")
    for needed in ("Project", "Session", "Results"):
        if not any(line.startswith(f"struct {FRONT}::{needed}") for line in door.lines):
            sys.exit(f"the front door has no {needed}: it was not read as it is")
    recorded = pathlib.Path(recorded)
    head = f"# Version {door.version}: what Rust programs may rely on, as tests/semver/front_door.py reads it."
    if accept:
        recorded.write_text("\n".join([head, *sorted(door.lines)]) + "\n")
        return
    first, *lines = recorded.read_text().splitlines()
    if first != head:
        sys.exit(f"{recorded} is of another version: record this one's by tests/semver/check --accept")
    gone = sorted(set(lines) - door.lines)
    more = len(door.lines - set(lines))
    if gone:
        print("\n".join(gone), file=sys.stderr)
        sys.exit(
            f"{len(gone)} of {len(lines)} things that programs may rely on are gone or say something else; {more} are new.\n"
            "Keep them, or raise the version in Cargo.toml, say in CHANGELOG.md what breaks, and run tests/semver/check --accept."
        )
    print(f"All of {len(lines)} things that programs may rely on are there, and {more} more.")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], "--accept" in sys.argv[3:])
