#!/usr/bin/env bash
# A column, or a fraction, that begins late in a file of JSON lines.
# Guessed: all readers give the column, with nulls before it begins, and 2.5 as it is.
# Seen: pandas and pyarrow do. polars and duckdb decide from the first rows (100; 20,480): both drop
# the column without a word, and duckdb rounds the fraction to 2; polars raises an error for it.
# Versions: polars==2.1.0, duckdb==2.0.1, pyarrow==26.0.1, pandas==3.1.1.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/python -m pip install -q polars==2.1.0 duckdb==2.0.1 pyarrow==26.0.1 pandas==3.1.1
venv/bin/python - <<'PYTHON'
import json

import duckdb
import pandas
import polars
import pyarrow.json

rows = [{"step": i} for i in range(30_000)]
for row in rows[25_000:]:
    row["heat"] = 1.5
with open("late.jsonl", "w") as file:
    file.writelines(json.dumps(row) + "\n" for row in rows)
columns = {
    "pandas": list(pandas.read_json("late.jsonl", lines=True).columns),
    "pyarrow": pyarrow.json.read_json("late.jsonl").column_names,
    "polars": polars.read_ndjson("late.jsonl").columns,
    "duckdb": duckdb.sql("select * from read_json_auto('late.jsonl')").columns,
}
print(columns)
assert columns["pandas"] == columns["pyarrow"] == ["step", "heat"]
assert columns["polars"] == columns["duckdb"] == ["step"]

with open("fraction.jsonl", "w") as file:
    file.writelines('{"cut":1}\n' for _ in range(25_000))
    file.write('{"cut":2.5}\n')
largest = {
    "pandas": pandas.read_json("fraction.jsonl", lines=True)["cut"].max(),
    "pyarrow": max(pyarrow.json.read_json("fraction.jsonl")["cut"].to_pylist()),
    "duckdb": duckdb.sql("select max(cut) from read_json_auto('fraction.jsonl')").fetchall()[0][0],
}
print(largest)
assert largest["pandas"] == largest["pyarrow"] == 2.5 and largest["duckdb"] in (2, 3)
try:
    polars.read_ndjson("fraction.jsonl")
except polars.exceptions.ComputeError as error:
    print("polars:", error)
else:
    raise AssertionError("polars reads the fraction")
PYTHON
