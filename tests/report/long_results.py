"""Results of a run that is many times as long."""

import json

import pyarrow as pa
import pyarrow.parquet as pq

GROUP = 12  # repetitions a row group, which has about as many rows as those of a replay


def repeated(results, out, times):
    """Results with a table that is `times` as long, in row groups like those of a replay."""
    summary = json.loads((results / "summary.json").read_text())
    table = pq.read_table(results / "estimates.parquet")
    stamps = table["stamp_ns"].to_numpy()
    period = int(stamps[-1] - stamps[0]) + 10_000_000
    out.mkdir()
    with pq.ParquetWriter(out / "estimates.parquet", table.schema, compression="none") as writer:
        for number in range(0, times, GROUP):
            parts = [shifted(table, (number + i) * period) for i in range(GROUP)]
            writer.write_table(pa.concat_tables(parts))
    summary |= {"duration": times * period * 1e-9, "smoothed": None}
    (out / "summary.json").write_text(json.dumps(summary))
    return out


def shifted(table, later_ns):
    for name in ("stamp_ns", "log_time_ns"):
        place = table.schema.get_field_index(name)
        times = pa.array(table[name].to_numpy() + later_ns)
        table = table.set_column(place, table.schema.field(place), times)
    return table
