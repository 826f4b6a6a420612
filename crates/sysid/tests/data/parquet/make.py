"""Writes the Parquet files of this folder, and the CSV file that holds the same numbers.

    pip install pyarrow==26.0.1 polars==2.1.0 pandas==3.1.1
    python make.py

Each good file is the same table as pyarrow, pandas and polars write it by default, and once with types and
encodings that are allowed but not the default; each bad one has one fault.
"""

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq

ROWS = 40
i = np.arange(ROWS)
# Singles and integers keep their value in every type that the files use.
table = {
    "time_s": i * 0.001,
    "current_a": np.round(2.0 * np.sin(0.3 * i), 3),
    "force_1_n": np.float32(0.25) * i.astype(np.float32),
    "motor_angle_rad": np.sin(0.1 * i) / 3.0,
    "index": i.astype(np.int64) - 7,
    "status": i.astype(np.uint8),
    "counter": (np.uint64(2**63) + i.astype(np.uint64) * np.uint64(2**20)),
}

with open("table.csv", "w", newline="\n") as out:
    out.write(",".join(table) + "\n")
    for row in range(ROWS):
        out.write(",".join(repr(column[row].item()) for column in table.values()) + "\n")

arrow = pa.table(table)
pq.write_table(arrow, "pyarrow.parquet")
pl.DataFrame(table).write_parquet("polars.parquet")
pd.DataFrame(table).to_parquet("pandas.parquet")
# Rows left out and not renumbered: pandas writes its index as one more column.
more = pd.concat([pd.DataFrame(table).iloc[:1], pd.DataFrame(table)])
more[1:].to_parquet("pandas_index.parquet", index=True)
pq.write_table(
    arrow,
    "pyarrow_zstd_v2_groups.parquet",
    compression="zstd",
    version="2.6",
    data_page_version="2.0",
    row_group_size=17,
    data_page_size=64,
)
pq.write_table(
    arrow,
    "pyarrow_delta_split.parquet",
    use_dictionary=False,
    column_encoding={
        "time_s": "BYTE_STREAM_SPLIT",
        "current_a": "PLAIN",
        "force_1_n": "BYTE_STREAM_SPLIT",
        "motor_angle_rad": "PLAIN",
        "index": "DELTA_BINARY_PACKED",
        "status": "DELTA_BINARY_PACKED",
        "counter": "PLAIN",
    },
    compression="none",
)


def bad(name, column, values, **options):
    pq.write_table(pa.table({**table, column: values}), f"bad_{name}.parquet", **options)


force = [float(x) for x in table["force_1_n"]]
bad("null", "force_1_n", force[:11] + [None] + force[12:], row_group_size=8)
bad("nan", "force_1_n", force[:11] + [float("nan")] + force[12:])
bad("infinite", "force_1_n", force[:11] + [float("-inf")] + force[12:])
bad("text", "force_1_n", [str(x) for x in force])
bad("boolean", "force_1_n", [x > 1 for x in force])
bad("timestamp", "time_s", pa.array(range(ROWS), pa.timestamp("ms")))
bad("list", "force_1_n", [[x] for x in force])
bad("repeated_time", "time_s", np.where(i == 11, 0.010, table["time_s"]), row_group_size=8)
bad("unit", "force_1_lbf", force)
bad("two_inputs", "motor_force_n", force)
pq.write_table(arrow.slice(0, 15), "bad_short.parquet")
pq.write_table(arrow.drop_columns("current_a"), "bad_no_input.parquet")
pq.write_table(arrow.drop_columns("time_s"), "bad_no_time.parquet")
pq.write_table(arrow, "bad_gzip.parquet", compression="gzip")
