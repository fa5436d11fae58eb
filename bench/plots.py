"""Which plots there are, and which figures they show. Pure functions: they run and read nothing.

docs/plots/draw.py draws them."""

import math
import statistics
import textwrap
from dataclasses import dataclass

import svg

NOTE_WIDTH = 84  # characters in a line of small text


@dataclass
class Plot:
    name: str  # the name of the plot's file
    title: str
    caption: str  # plain text: what is shown, and where a peer is better
    bench: str  # the benchmark whose figures are shown
    part: svg.Part
    about: dict  # how the figures were measured

    def svg(self):
        text = ", ".join(self.about[key] for key in ("command", "date", "processors", "system") if key in self.about)
        return svg.picture(self.title, self.part, textwrap.wrap(text, NOTE_WIDTH))


def all_plots(records):
    """Returns the plots whose figures are among the records."""
    plots = [make(records) for make in (wire_bytes, latency_between_hosts, latency_within_host, throughput,
                                        isolation_of_readers, isolation_of_publish, growth)]
    return [plot for plot in plots if plot is not None]


def plot(records, name, title, caption, bench, part):
    return Plot(name, title, caption, bench, part, records.about.get(bench, {}))


def value_of(records, bench, name, key="value", scale=1.0):
    figure = records.figure(bench, name)
    value = None if figure is None else figure.get(key)
    return value * scale if isinstance(value, (int, float)) and math.isfinite(value) else None


def stacked(parts):
    """Returns one part with these parts, one above the other."""
    whole = svg.Part(0)
    for part in parts:
        whole.elements += [f'<g transform="translate(0 {whole.height})">', *part.elements, "</g>"]
        whole.height += part.height + 8
    return whole


def best(rows, ours, more):
    """Returns the best value, of SFT or of the others, and its name; None if there is none."""
    found = [(value, name) for name, value in rows if name.startswith("SFT") == ours and svg.is_positive(value)]
    return (max(found) if more else min(found)) if found else None


def in_words(groups, unit, more=False):
    """Says where a peer is better than SFT. `groups`: pairs of a heading and a list of pairs (contender, value)."""
    behind, compared = [], 0
    for heading, rows in groups:
        ours, theirs = best(rows, True, more), best(rows, False, more)
        if theirs is None:
            continue
        compared += 1
        if ours is None:
            behind.append(f"{heading} ({theirs[1]}: {svg.number(theirs[0])} {unit}, SFT has no value)")
        elif (theirs[0] > ours[0]) if more else (theirs[0] < ours[0]):
            behind.append(f"{heading} ({theirs[1]}: {svg.number(theirs[0])} {unit}, "
                          f"{ours[1]}: {svg.number(ours[0])} {unit})")
    if behind:
        return "A peer is better in: " + "; ".join(behind) + "."
    return "SFT is better than each peer." if compared else "There is no peer to compare with."


MESSAGES = (("laserscan", "LaserScan without intensities"), ("battery", "BatteryState, one field"),
            ("bandwidth_50", "made messages, half of the fields"), ("bandwidth_100", "made messages, all fields"),
            ("occupancygrid", "OccupancyGrid, all fields"),
            ("pointcloud2_aggregate", "PointCloud2 of 16 kB, sum of three readers"))


def wire_bytes(records):
    groups = [(heading, [("SFT", value_of(records, "paper", name)),
                         ("Cyclone DDS", value_of(records, "paper", name, "reference")),
                         ("Fast DDS", value_of(records, "paper", name + "_vs_fast_dds", "reference"))])
              for name, heading in MESSAGES if records.figure("paper", name) is not None]
    if not groups:
        return None
    return plot(records, "bytes", "Bytes of a message at its readers",
                "Bytes of a message at the interfaces of its readers, with all headers, best effort and unicast. "
                "Readers of SFT ask for the fields that they read. " + in_words(groups, "B"), "paper",
                svg.bars(groups, "bytes of a message (logarithmic), fewer are better"))


def median_of(rows, column):
    values = [float(row[column]) for row in rows if is_number(row.get(column))]
    return statistics.median(values) if values else None


def is_number(text):
    try:
        return math.isfinite(float(text))
    except (TypeError, ValueError):
        return False


def size_text(size):
    for limit, unit in ((1 << 20, "MiB"), (1 << 10, "KiB")):
        if size >= limit:
            return f"{size / limit:g} {unit}"
    return f"{size:g} B"


BETWEEN_HOSTS = (("sft_full", "SFT, all data"), ("sft_two_fields", "SFT, two fields"), ("cyclone", "Cyclone DDS"),
                 ("fast_dds", "Fast DDS"), ("tcp", "TCP"), ("udp", "UDP"))
WITHIN_HOST = (("sft_full", "SFT, copied"), ("sft_loan", "SFT, loan"), ("iceoryx", "iceoryx, copied"),
               ("iceoryx_loan", "iceoryx, loan"), ("cyclone_iceoryx", "Cyclone DDS, iceoryx"),
               ("fast_dds_memory", "Fast DDS, memory"))
BANDED = ("SFT, all data", "Cyclone DDS", "SFT, loan", "iceoryx, loan")  # with more bands, some would hide others


def latency(records, group, contenders, rivals, name, title, caption):
    """Plots latency over size. `rivals`: sets of contenders that do the same work, so that they can be compared."""
    series, by_size = [], {}
    for contender, label in contenders:
        points = []
        of_contender = [row for row in records.tables.get("peers.csv", [])
                        if row.get("group") == group and row.get("contender") == contender and is_number(row["bytes"])]
        for size in sorted({float(row["bytes"]) for row in of_contender}):
            rows = [row for row in of_contender if float(row["bytes"]) == size]
            p50, p999 = median_of(rows, "p50_us"), median_of(rows, "p999_us")
            if not svg.is_positive(p50):
                continue
            by_size.setdefault(size, {})[label] = p50
            # Without upper ends there is no band, only a curve.
            points.append((size, p50, p999 if label in BANDED and svg.is_positive(p999) else p50))
        series.append((label, points))
    if not by_size:
        return None
    words = in_words([(size_text(size), [(label, p50) for label, p50 in rows.items() if label in labels])
                      for labels in rivals for size, rows in sorted(by_size.items())], "us")
    banded = " and ".join(label for _, label in contenders if label in BANDED)
    return plot(records, name, title,
                f"p50 from publish() until the program of the reader has the message; bands up to the p99.9 of "
                f"{banded} (with fewer than 1,000 messages, the worst one). {caption} {words}", "peers",
                svg.curves(series, "size of the message, bytes", "latency (logarithmic), us", size_text))


def latency_between_hosts(records):
    return latency(records, "inter_sleeping", BETWEEN_HOSTS,
                   [{label for _, label in BETWEEN_HOSTS} - {"SFT, two fields"}],
                   "latency_hosts", "Latency between hosts, asleep",
                   "Two fields are two numbers of the message; the other curves are of all its data.")


def latency_within_host(records):
    loans = {"SFT, loan", "iceoryx, loan"}
    return latency(records, "intra_sleeping", WITHIN_HOST, [{label for _, label in WITHIN_HOST} - loans, loans],
                   "latency_memory", "Latency within one host, asleep",
                   "Copied: the message begins in the program's own memory. Loan: in memory that is lent.")


def throughput(records):
    def rows(name, cyclone, fast_dds):
        return [("SFT", value_of(records, "udp", name)), ("UDP, GSO", value_of(records, "udp", name, "reference")),
                ("Cyclone DDS", value_of(records, "udp", cyclone, "reference")),
                ("Fast DDS", value_of(records, "udp", fast_dds, "reference"))]

    rates = [("throughput", rows("bulk_4MiB_reliable", "bulk_4MiB_vs_cyclone", "bulk_4MiB_vs_fast_dds"))]
    costs = [("processor time", rows("cpu_per_GB", "cpu_per_GB_vs_cyclone", "cpu_per_GB_vs_fast_dds"))]
    if all(value is None for _, value in rates[0][1] + costs[0][1]):
        return None
    return plot(records, "throughput", "Throughput and processor time, 4 MiB",
                "Reliable samples of 4 MiB between two hosts as fast as possible, and the processor time of both sides "
                "for a gigabyte. UDP, GSO: raw sockets with GSO and GRO. " + in_words(rates, "GB/s", more=True) + " "
                + in_words(costs, "s/GB"), "udp",
                stacked([svg.bars(rates, "GB/s (logarithmic), more are better"),
                         svg.bars(costs, "processor seconds per GB (logarithmic), fewer are better")]))


SITUATIONS = (("joined", "it joins"), ("stalled", "it is stopped"), ("lossy", "it loses 20 %"), ("narrow", "50 Mbit/s"),
              ("killed", "it is killed"))
SUFFIXES = (("SFT", ""), ("Cyclone DDS", "_cyclone"), ("Fast DDS", "_fast_dds"))


def isolation(records, of, name, title, caption):
    def row(situation, suffix, key):
        return value_of(records, "isolation", f"isolation_{situation}_{of}_p99{suffix}", key, 1e-3)

    groups = [("without the remote reader", [(contender, row("joined", suffix, "reference"))
                                             for contender, suffix in SUFFIXES])]
    groups += [(heading, [(contender, row(situation, suffix, "value")) for contender, suffix in SUFFIXES])
               for situation, heading in SITUATIONS]
    if all(value is None for _, rows in groups for _, value in rows):
        return None
    quiet = dict(groups[0][1])
    ratios = [(heading, [(contender, value / quiet[contender])
                         for contender, value in rows if value is not None and svg.is_positive(quiet[contender])])
              for heading, rows in groups[1:]]
    return plot(records, name, title,
                f"{caption} Messages have 6.3 MB, and are reliable. {in_words(groups, 'ms')} As a ratio to the time "
                f"without the remote reader: {in_words(ratios, 'times')}", "isolation",
                svg.bars(groups, "p99, ms (logarithmic), less is better"))


def isolation_of_readers(records):
    return isolation(records, "local", "isolation_readers", "Local readers beside a bad remote one",
                     "p99 of the time until a reader on the publisher's host has a message.")


def isolation_of_publish(records):
    return isolation(records, "publish", "isolation_publish", "publish() beside a bad remote reader",
                     "p99 of the duration of publish().")


COSTS = (("time", "s", "all matched"), ("bytes", "MB", "traffic until then"), ("cpu", "s", "CPU time until then"),
         ("idle", "B/s", "idle, received"))


def growth(records):
    names = [figure["name"].split("_") for figure in records.figures.get("many", [])
             if isinstance(figure.get("name"), str)]
    sizes = sorted({int(words[1]) for words in names
                    if len(words) == 3 and words[0] == "growth" and words[1].isdecimal()})
    if not sizes:
        return None
    parts, words = [], []
    for cost, unit, title in COSTS:
        pairs = [(size, [(contender, value_of(records, "many", f"growth_{size}_{cost}", key))
                         for contender, key in (("SFT", "value"), ("Cyclone DDS", "reference"))]) for size in sizes]
        series = [(name, [(size, dict(rows)[name]) for size, rows in pairs]) for name in ("SFT", "Cyclone DDS")]
        parts.append(svg.curves(series, "nodes with ten endpoints each", f"{title}, {unit}", str, height=110))
        words.append(f"{title}: " + in_words([(f"{size} nodes", rows) for size, rows in pairs], unit))
    return plot(records, "growth", "Nodes that find each other",
                "A curve ends where nodes did not match in time. " + " ".join(words), "many", stacked(parts))
