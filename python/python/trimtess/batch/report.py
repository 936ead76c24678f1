"""A catalogue -> text: totals, throughput, what was slow, what was large, what failed and why."""

from __future__ import annotations

import collections
import datetime
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Tuple

import pyarrow
import pyarrow.compute as compute

from .catalogue import STAGES, STATUSES
from .options import Json
from .plan import MIB

if TYPE_CHECKING:
    from .drive import Summary

#: Intervals of the throughput over time.
INTERVALS = 24

#: Shades of a bar, from none to full.
SHADES = " ▁▂▃▄▅▆▇█"


def summary_line(summary: "Summary") -> str:
    """One line for the end of a run."""
    done = summary.files - summary.known
    speed = f" in {summary.seconds:.1f} s ({done / summary.seconds:.1f} a second)" if summary.seconds else ""
    known = f", {summary.known} had their row before" if summary.known else ""
    return f"{done} of {summary.files} files converted{speed}{known}: {by_count(summary.statuses)}"


def by_count(statuses: Dict[str, int]) -> str:
    return ", ".join(f"{statuses[status]} {status}" for status in STATUSES if statuses.get(status))


def text(head: Json, table: pyarrow.Table, top: int) -> str:
    """The report."""
    options = ", ".join(f"{name} {value}" for name, value in head["options"].items() if value not in (None, False))
    lines = [f"trimtess {head['version']}: {options}", ""]
    lines += totals(table)
    lines += throughput_lines(table)
    lines += ranked("slowest", table, "seconds", top, lambda value: f"{value:9.2f} s  ")
    lines += ranked("most memory", table, "peak_memory", top, lambda value: f"{value / MIB:9.0f} MiB")
    lines += failures(table, top)
    lines += kinds(table, top)
    return "\n".join(lines) + "\n"


def totals(table: pyarrow.Table) -> List[str]:
    counts = collections.Counter(str(status) for status in table["status"].to_pylist())
    lines = [f"{len(table)} files: {by_count(counts) or 'none'}"]
    size, triangles = total(table["size"]), total(table["triangles"])
    closed = total(compute.cast(table["closed"], pyarrow.int64()))
    lines.append(f"{size / 1e6:.1f} MB in, {triangles} triangles, {closed} files with all parts closed")
    again = sum(attempts > 1 for attempts in table["attempts"].to_pylist() if attempts is not None)
    reused = total(compute.cast(table["reused"], pyarrow.int64()))
    lines.append(f"{again} files took several attempts, {reused} had the content of another or were found made")
    hosts = collections.Counter(host for host in table["host"].to_pylist() if host)
    lines.append(f"{len(hosts)} hosts, {len(set(table['run'].to_pylist()))} runs")
    seconds = {stage: total(table[f"seconds_{stage}"]) for stage in STAGES}
    lines.append("seconds per stage: " + ", ".join(f"{stage} {value:.1f}" for stage, value in seconds.items() if value))
    return lines


def total(column: Any) -> float:
    return compute.sum(column).as_py() or 0


def throughput(table: pyarrow.Table, intervals: int = INTERVALS) -> Tuple[List[float], List[int]]:
    """Ends of equal intervals in seconds from the first start, and files finished in each. Empty without rows."""
    ends = [end.timestamp() for end in table["finished"].to_pylist() if end is not None]
    starts = [start.timestamp() for start in table["started"].to_pylist() if start is not None]
    if not ends:
        return [], []
    first, last = min(starts), max(ends)
    length = max(last - first, 1e-6) / intervals
    counts = collections.Counter(min(intervals - 1, int((end - first) / length)) for end in ends)
    return [(number + 1) * length for number in range(intervals)], [counts[number] for number in range(intervals)]


def throughput_lines(table: pyarrow.Table) -> List[str]:
    ends, counts = throughput(table)
    if not ends:
        return []
    most = max(counts)
    bar = "".join(SHADES[-(-count * (len(SHADES) - 1) // most)] for count in counts)
    span = ends[-1]
    first = min(start for start in table["started"].to_pylist() if start is not None)
    peak = most / (span / len(ends))
    return [
        "",
        f"throughput from {first:%Y-%m-%d %H:%M:%S} UTC, {datetime.timedelta(seconds=round(span))}: "
        f"{len(table) / span:.1f} files a second, {peak:.1f} at most",
        f"  |{bar}|",
    ]


def ranked(title: str, table: pyarrow.Table, column: str, top: int, words: Callable[[float], str]) -> List[str]:
    """The files with the largest values of a column."""
    known = table.filter(compute.is_valid(table[column])).sort_by([(column, "descending"), ("path", "ascending")])
    rows = known.slice(0, top).select([column, "size", "status", "path"]).to_pylist()
    lines = [f"  {words(row[column])}  {megabytes(row['size'])}  {row['status']:<8} {row['path']}" for row in rows]
    return ["", f"{title}:", *lines] if lines else []


def megabytes(size: Optional[int]) -> str:
    return "        " if size is None else f"{size / 1e6:5.1f} MB"


def failures(table: pyarrow.Table, top: int) -> List[str]:
    """Files without outputs, by status and reason."""
    rows = table.filter(compute.invert(compute.is_in(table["status"], value_set=pyarrow.array(["whole", "partial"]))))
    counts = collections.Counter(
        (row["status"], without_numbers(row["message"] or "")) for row in rows.select(["status", "message"]).to_pylist()
    )
    lines = [f"  {count:6}  {status}: {message}" for (status, message), count in counts.most_common(top)]
    return ["", "failures by kind:", *lines] if lines else []


def without_numbers(message: str) -> str:
    """A message with its numbers replaced, so that those of one kind are equal."""
    words = ("…" if any(sign.isdigit() for sign in word) else word for word in message.split())
    return " ".join(words)


def kinds(table: pyarrow.Table, top: int) -> List[str]:
    """Diagnostics by code: how many, and in how many files."""
    total_of: "collections.Counter[str]" = collections.Counter()
    files: "collections.Counter[str]" = collections.Counter()
    for found in table["diagnostics"].to_pylist():
        for code, count in found or ():
            total_of[code] += count
            files[code] += 1
    lines = [f"  {count:6}  {code} in {files[code]} files" for code, count in total_of.most_common(top)]
    return ["", "diagnostics by kind:", *lines] if lines else []
