#!/usr/bin/env bash
# Numbers at the ends of their ranges in a line of JSON.
# Guessed: readers that promise all digits of a double give all doubles back, and a 64-bit integer
# stays an integer.
# Seen: pandas: precise_float=True refuses the smallest double with an error; without it that double
# becomes 0 and the largest one loses its last digits. pyarrow gives 2^64 - 1 as the double 2^64;
# polars, duckdb and pandas keep it.
# Versions: polars==2.1.0, duckdb==2.0.1, pyarrow==26.0.1, pandas==3.1.1.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/python -m pip install -q polars==2.1.0 duckdb==2.0.1 pyarrow==26.0.1 pandas==3.1.1
venv/bin/python - <<'PYTHON'
import duckdb
import pandas
import polars
import pyarrow.json

with open("doubles.jsonl", "w") as file:
    file.write('{"least":5e-324,"most":1.7976931348623157e308}\n')
rough = pandas.read_json("doubles.jsonl", lines=True)
print(rough)
assert rough["least"][0] == 0 and rough["most"][0] < 1.7976931348623157e308
try:
    pandas.read_json("doubles.jsonl", lines=True, precise_float=True)
except ValueError as error:
    print("precise_float:", error)
else:
    raise AssertionError("precise_float reads the smallest double")

whole = 2**64 - 1
with open("seed.jsonl", "w") as file:
    file.write('{"seed":%d}\n' % whole)
read = {
    "pyarrow": pyarrow.json.read_json("seed.jsonl")["seed"][0].as_py(),
    "polars": polars.read_ndjson("seed.jsonl")["seed"][0],
    "pandas": int(pandas.read_json("seed.jsonl", lines=True)["seed"][0]),
    "duckdb": duckdb.sql("select seed from read_json_auto('seed.jsonl')").fetchall()[0][0],
}
print(read)
assert isinstance(read["pyarrow"], float) and read["pyarrow"] == 2.0**64
assert read["polars"] == read["pandas"] == read["duckdb"] == whole
PYTHON
