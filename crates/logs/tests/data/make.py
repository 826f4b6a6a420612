"""Writes the log files of this folder: the same run in every format, as other people's tools write it.

    pip install numpy==2.4.6 scipy==1.17.1 pyarrow==26.0.1 mcap==1.6.0 rosbags==0.11.9 h5py==3.16.0
    python make.py

small.rrd comes from the project's own recorder (crates/sealegs/tests/rrd.rs with WRITE_SMALL_RRD=FILE), without its layout
and its footer.

Forty rows at 1 kHz: time `t` (s), position `q` (rad), a command `u` (V) and the number of the row `i`.
"""

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

ROWS = 40
i = np.arange(ROWS)
t = i * 0.001
q = np.round(0.5 * np.sin(0.2 * i), 6)
u = np.where(i % 10 < 5, 1.5, -1.5)
START_NS = 1_700_000_000_123_456_789

# CSV as a German spreadsheet writes it, as numpy.savetxt does, and with spaces.
with open("semicolon.csv", "w") as out:
    out.write("t;q;u;i\n")
    for row in range(ROWS):
        out.write(f"{t[row]:.3f};{q[row]:.6f};{u[row]};{i[row]}\n".replace(".", ","))
np.savetxt("savetxt.txt", np.column_stack([t, q, u, i]), header="t q u i")
with open("comments.csv", "w") as out:
    out.write("# a rig\n\n t, q ,\"u\",i\n")
    for row in range(ROWS):
        out.write(f"{t[row]:.3f}, {q[row]:.6f}, {u[row]}, {i[row]}\n")
        if row == 7:
            out.write("# a remark\n\n")

# MATLAB of level 5, packed and plain, at the top and inside a structure.
names = {"t": t, "q": q, "u": u, "i": i.astype(np.int32), "gain": 35.15, "label": "a rig"}
scipy.io.savemat("packed.mat", names, do_compression=True, oned_as="column")
scipy.io.savemat("plain.mat", {"data": {**names, "both": np.column_stack([q, u])}}, oned_as="row")
# Signals as dSPACE records them, and as Simulink writes a structure with time.
def structures(signals, label, values):
    """A structure array of signals by name."""
    out = np.empty(len(signals), dtype=[(label, object), (values, object)])
    for place, (name, of) in enumerate(signals.items()):
        out[place] = (name, of)
    return out


recorded = {"X": {"Name": "Time", "Data": t}, "Y": structures({"angle": q, "Model Root/volts": u}, "Name", "Data")}
scipy.io.savemat("dspace.mat", {"rec": recorded}, oned_as="row")
logged = {"time": t, "signals": structures({"angle": q, "volts": u}, "label", "values")}
scipy.io.savemat("simulink.mat", {"logged": logged}, do_compression=True, oned_as="column")
# MATLAB of level 7.3: HDF5 behind a header of MATLAB's; the last index is its first, truth and text are whole numbers.
with h5py.File("level73.mat", "w", userblock_size=512) as out:
    data = out.create_group("data")
    data.attrs["MATLAB_class"] = np.bytes_("struct")
    for place, name, values, kind in [
        (out, "t", t[np.newaxis], "double"),
        (data, "q", q[np.newaxis], "double"),
        (data, "both", np.vstack([q, u]), "double"),
        (data, "i", i[np.newaxis].astype(np.int32), "int32"),
        (data, "on", (u > 0)[np.newaxis].astype(np.uint8), "logical"),
        (out, "gain", np.array([[35.15]]), "double"),
        (out, "label", np.array([[ord(c)] for c in "a rig"], dtype=np.uint16), "char"),
        (out, "nothing", np.array([0, 0], dtype=np.uint64), "double"),
    ]:
        packed = {"compression": "gzip", "chunks": values.shape} if values.size > 4 else {}
        place.create_dataset(name, data=values, **packed).attrs["MATLAB_class"] = np.bytes_(kind)
    out["nothing"].attrs["MATLAB_empty"] = np.uint8(1)
with open("level73.mat", "r+b") as out:
    out.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")

# HDF5 as h5py writes it: packed in chunks, in groups, stamps in ns.
with h5py.File("plain.h5", "w") as out:
    out.create_dataset("rig/t", data=t, chunks=(16,), compression="gzip", shuffle=True, fletcher32=True)
    out["rig/q"] = q.astype(">f4")
    out["rig/motor/both"] = np.column_stack([q, u])
    out["rig/stamp_ns"] = START_NS + i * 1_000_000
    out["rig/on"] = u > 0
    out["rig/label"] = "a rig"
    out["gain"] = 35.15

# NumPy.
np.savez("plain.npz", t=t, q=q.astype(np.float32), u=u, i=i, both=np.column_stack([q, u]), gain=35.15)
np.savez_compressed("packed.npz", t=t, q=q.astype(">f8"), u=u, i=i.astype(np.uint16))
record = np.zeros(ROWS, dtype=[("t", "<f8"), ("q", "<f4"), ("pair", "<i2", (2,)), ("on", "?"), ("name", "<U4")])
record["t"], record["q"], record["pair"], record["on"] = t, q, np.column_stack([i, -i]), u > 0
np.save("record.npy", record)
np.save("matrix.npy", np.asfortranarray(np.column_stack([t, q, u])))

# JSON: entries, columns, lines.
entries = [
    {"t": t[r], "motor": {"q": q[r], "pair": [u[r], int(i[r])]}, "on": bool(u[r] > 0)} for r in range(ROWS)
]
Path("entries.json").write_text(json.dumps({"kp": 100, "rig": "a", "entries": entries}))
Path("columns.json").write_text(json.dumps({"t": t.tolist(), "q": q.tolist(), "u": u.tolist(), "i": i.tolist()}))
Path("lines.jsonl").write_text("\n".join(json.dumps(e) for e in entries) + "\n")

# LeRobot's layout: lists of one length, three episodes, time in seconds from each one's start.
episode = np.repeat([0, 1, 2], ROWS)
state = np.column_stack([np.tile(q, 3) + episode, np.tile(u, 3)]).astype(np.float32)
pq.write_table(
    pa.table(
        {
            "observation.state": pa.array(state.tolist(), type=pa.list_(pa.float32(), 2)),
            "action": pa.array(state[:, 1:].tolist(), type=pa.list_(pa.float32())),
            "timestamp": np.tile(t, 3).astype(np.float32),
            "frame_index": np.tile(i, 3),
            "episode_index": episode,
            "index": np.arange(3 * ROWS),
            "next.done": np.tile(i == ROWS - 1, 3),
            "task": ["stand"] * (3 * ROWS),
            "stamp": pa.array(START_NS + np.tile(i, 3) * 1_000_000, type=pa.timestamp("ns")),
        }
    ),
    "lerobot.parquet",
)

# MCAP with JSON messages.
for compression in (CompressionType.NONE, CompressionType.ZSTD, CompressionType.LZ4):
    with open(f"json_{compression.name.lower()}.mcap", "wb") as out:
        writer = Writer(out, compression=compression)
        writer.start()
        schema = writer.register_schema("rig", "jsonschema", b"{}")
        channel = writer.register_channel("/rig", "json", schema)
        for row in range(ROWS):
            stamp = START_NS + row * 1_000_000
            message = json.dumps({"q": q[row], "u": u[row], "i": int(i[row])}).encode()
            writer.add_message(channel, stamp, message, stamp)
        writer.finish()

# ROS 2 bags: joint states at 1 kHz, commands at 100 Hz, in MCAP and SQLite.
store = get_typestore(Stores.ROS2_HUMBLE)
types = store.types
for plugin, ending in ((StoragePlugin.MCAP, "mcap"), (StoragePlugin.SQLITE3, "db3")):
    folder = Path("bag")
    shutil.rmtree(folder, ignore_errors=True)
    with BagWriter(folder, version=8, storage_plugin=plugin) as bag:
        names = [
            ("/joint_states", "sensor_msgs/msg/JointState"),
            ("/command", "std_msgs/msg/Float64"),
            ("/commands", "std_msgs/msg/Float64MultiArray"),
        ]
        states, command, commands = (bag.add_connection(n, k, typestore=store) for n, k in names)
        for row in range(ROWS):
            stamp = START_NS + row * 1_000_000
            time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
            header = types["std_msgs/msg/Header"](time, "base")
            kind = types["sensor_msgs/msg/JointState"]
            both = ["knee", "ankle"]
            position = np.array([q[row], -q[row]])
            if row % 2:
                both, position = both[::-1], position[::-1].copy()
            message = kind(header, both, position, position * 2, np.array([]))
            bag.write(states, stamp + 300_000, store.serialize_cdr(message, states.msgtype))
            if row % 10 == 0:
                value = types["std_msgs/msg/Float64"](u[row])
                bag.write(command, stamp, store.serialize_cdr(value, command.msgtype))
                layout = types["std_msgs/msg/MultiArrayLayout"]([], 0)
                value = types["std_msgs/msg/Float64MultiArray"](layout, np.array([u[row], float(row)]))
                bag.write(commands, stamp, store.serialize_cdr(value, commands.msgtype))
    shutil.move(next(folder.glob(f"*.{ending}")), f"bag.{ending}")
    shutil.rmtree(folder)
