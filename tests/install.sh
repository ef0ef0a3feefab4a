#!/bin/sh
# Installs what smidgen needs: Debian packages where that is permitted, then a virtual
# environment with pinned packages. Exit 6, with one line that names what to install,
# where a Debian package is missing and cannot be installed from here.
#   sh tests/install.sh .venv       the environment and what it needs
#   sh tests/install.sh --extras    what only tests use; never fails
set -eu
cd "$(dirname "$0")/.."
PYTHON="${PYTHON:-python3}"

has()        { command -v "$1" >/dev/null 2>&1; }
has_venv()   { has "$PYTHON" && "$PYTHON" -c 'import ensurepip, venv' 2>/dev/null; }
has_header() { has cc && printf '#include <%s>\n' "$1" | cc -E - >/dev/null 2>&1; }
may_install() { has apt-get && [ "$(id -u)" = 0 ]; }

needed() {
  has "$PYTHON" || echo python3
  has_venv || echo python3-venv
  { has cc && has g++ && has_header math.h; } || echo gcc g++ libc6-dev
  has pkg-config || echo pkg-config
  has_header gsl/gsl_multiroots.h || echo libgsl-dev
}

sanitizes() { echo 'int main(void) { return 0; }' | clang -fsanitize=address -x c - -o /dev/null 2>/dev/null; }
extras() {
  { has clang++ && sanitizes; } || echo clang libclang-rt-dev
  has chromium || echo chromium
  has clang-format || echo clang-format
  { has mpicc && has mpirun; } || echo libopenmpi-dev openmpi-bin
}

apt_install() {
  export DEBIAN_FRONTEND=noninteractive
  apt-get update -qq && apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

if [ "${1:-}" = --extras ]; then
  want=$(extras | tr '\n' ' ')
  [ -z "$want" ] || { may_install && apt_install $want; } ||
    echo "smidgen: some tests will be skipped without: $want" >&2
  exit 0
fi

venv=$1
want=$(needed | tr '\n' ' ')
if [ -n "$want" ]; then
  { may_install && echo "smidgen: installing $want (some minutes)" >&2 && apt_install $want; } ||
    { echo "smidgen: install these first: apt-get install $want" >&2; exit 6; }
fi
"$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
  { echo "smidgen: install Python 3.11 or newer, or name one: make PYTHON=python3.11" >&2; exit 6; }
[ -x "$venv/bin/pip" ] || { rm -rf "$venv"; "$PYTHON" -m venv "$venv"; }
pip() { "$venv/bin/python" -m pip --disable-pip-version-check "$@" >"$venv/install.log" 2>&1 ||
  { cat "$venv/install.log" >&2; exit 1; }; }
echo "smidgen: installing Python packages into $venv (some minutes)" >&2
pip install --no-compile -r requirements.txt -r requirements-test.txt  # what is imported is compiled then
pip install --no-compile --no-deps --no-build-isolation -e .
