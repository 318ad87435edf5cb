# shellcheck shell=bash
# What the judges share: scripts that check the program with tools made by others, such as a browser, pytest and Ray.
#
# A judge sources this file before it changes its folder: relative paths in the two variables count from the caller's folder.
#
#   SCENARIO_RUNNER          The program that is judged. By default Cargo's release build of this checkout, which `settle_program` makes.
#   SCENARIO_RUNNER_JUDGES   The folder of installed environments and of scratch files. By default target/judges of this checkout.

# Failed commands within $(…) end the script, too.
shopt -s inherit_errexit

SCENARIO_RUNNER_JUDGES=$(realpath --canonicalize-missing -- "${SCENARIO_RUNNER_JUDGES:-$(dirname -- "${BASH_SOURCE[0]}")/../../target/judges}")
export SCENARIO_RUNNER_JUDGES
if [ -n "${SCENARIO_RUNNER-}" ]; then
    SCENARIO_RUNNER=$(realpath --canonicalize-missing --no-symlinks -- "$SCENARIO_RUNNER")
fi

# settle_program: exports the absolute path of the program that is judged as SCENARIO_RUNNER.
settle_program() {
    settle SCENARIO_RUNNER scenario-runner
}

# settle VARIABLE PATH ARGUMENT...: exports the absolute path of a program as VARIABLE. If VARIABLE is unset or empty, Cargo builds the program with
# these arguments into PATH below the folder of release builds.
settle() {
    local root program=${!1-}
    if [ -z "$program" ]; then
        root=$(realpath -- "$(dirname -- "${BASH_SOURCE[0]}")/../..")
        (cd "$root" && cargo build --release --quiet "${@:3}") || return
        program=$(cd "$root" && realpath --canonicalize-missing -- "${CARGO_TARGET_DIR:-target}/release/$2")
    fi
    if [ ! -f "$program" ] || [ ! -x "$program" ]; then
        echo "$1 names $program, which is not a program that can be run" >&2
        return 1
    fi
    declare -gx "$1=$program"
}

# python_environment NAME REQUIREMENTS: prints the path of a Python environment with the packages of the file REQUIREMENTS.
python_environment() {
    installed "$1-$(short_hash "$2")" install_python_packages "$2"
}

install_python_packages() {
    python3 -m venv "$2" && "$2/bin/pip" install --quiet --disable-pip-version-check --requirement "$1"
}

# node_environment NAME FOLDER: prints the path of a folder whose node_modules has the packages of FOLDER/package-lock.json.
node_environment() {
    installed "$1-$(short_hash "$2/package-lock.json")" install_node_packages "$2"
}

# No package runs scripts of its own when it is installed.
install_node_packages() {
    cp "$1/package.json" "$1/package-lock.json" "$2/" && (cd "$2" && npm ci --ignore-scripts --no-audit --no-fund --silent)
}

# installed NAME COMMAND...: prints the path of the folder NAME among the environments. The first call has COMMAND fill the folder, whose path is its
# last argument; a second call that comes meanwhile waits. COMMAND returns an exit code other than 0 if anything in it failed.
installed() {
    local folder=$SCENARIO_RUNNER_JUDGES/$1
    mkdir -p "$SCENARIO_RUNNER_JUDGES" || return
    {
        flock 9 || return
        if [ ! -e "$folder/installed" ]; then
            rm -rf "$folder" && mkdir "$folder" && "${@:2}" "$folder" >&2 9>&- && touch "$folder/installed" || return
        fi
    } 9>"$folder.lock"
    echo "$folder"
}

# short_hash FILE: the first 16 hexadecimal digits of its SHA-256.
short_hash() {
    sha256sum -- "$1" | cut -c1-16
}
