"""Makes captures by hand, and reads captures with Wireshark's dissector."""
import os
import pathlib
import re
import shutil
import struct
import subprocess
import tempfile

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "tools/wireshark/sft.lua"
SFT_PORT = 7777
VERSION = 2 << 4
STAMP = 1_500_000_000_000_000_001


def write_pcap(path, payloads):
    """Writes a capture with one UDP datagram per payload, over IPv4 without a link layer."""
    with open(path, "wb") as out:
        out.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 101))
        for number, payload in enumerate(payloads):
            udp = struct.pack(">HHHH", 40000, SFT_PORT, 8 + len(payload), 0) + payload
            ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), number, 0, 64, 17, 0,
                             bytes([10, 0, 0, 1]), bytes([10, 0, 0, 2]))
            out.write(struct.pack("<IIII", number, 0, len(ip + udp), len(ip + udp)) + ip + udp)


def run_tshark(path, arguments):
    """Returns tshark's output for a capture. If root runs this, tshark runs as nobody: 4.4 runs no Lua as root."""
    nobody = 65534
    account = {"user": nobody, "group": nobody, "extra_groups": []} if os.geteuid() == 0 else {}
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o755)
        files = [shutil.copy(file, folder) for file in (SCRIPT, path)]
        for file in files:
            os.chmod(file, 0o644)
        command = ["tshark", "-n", "-X", f"lua_script:{files[0]}", "-r", files[1], *arguments]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, env={**os.environ, "HOME": folder},
                              **account)
    assert done.returncode == 0 and "Lua: Error" not in done.stderr, done.stderr
    return done.stdout


def dissect(path, fields, decode_as=False, preferences=()):
    """Returns the values of these fields for each datagram. Several values of one field are joined by commas."""
    # The system may assign ports that are registered for other protocols. So Wireshark tries its heuristics on the
    # content of a datagram first.
    arguments = ["-T", "fields", "-E", "separator=|"]
    for preference in ("udp.try_heuristic_first:TRUE", *preferences):
        arguments += ["-o", preference]
    if decode_as:
        arguments += ["-d", f"udp.port=={SFT_PORT},sft"]
    for field in fields:
        arguments += ["-e", field]
    # Wireshark 4.4 prints booleans as words.
    printed = re.sub(r"\b(True|False)\b", lambda word: str(int(word[0] == "True")), run_tshark(path, arguments))
    return [dict(zip(fields, line.split("|"))) for line in printed.splitlines()]


def header(kind, at_2=3, flags=0, writer=0x04030201, at_8=9):
    return struct.pack("<BBHII", VERSION | kind, flags, at_2, writer, at_8)


NARROW_MASK = 0x20


def mask_bytes(mask):
    """Returns a mask as bytes of a header, and the flag for the length of these bytes."""
    return (struct.pack("<H", mask), NARROW_MASK) if mask < 1 << 16 else (struct.pack("<Q", mask), 0)


def first(body=b"body", flags=0, total=None, mask=0x87, marks=b""):
    total = len(body) if total is None else total
    packed_mask, width = mask_bytes(mask)
    return header(1, flags=flags | width) + struct.pack("<Iq", total, STAMP) + packed_mask + marks + body


def whole(body=b"body", flags=0, variant=3, channel=5, ordinal=12, stamp=STAMP, mask=0x87):
    """Returns a whole datagram. `flags` are the two lower bits of the field `place`."""
    packed_mask, width = mask_bytes(mask)
    place = VERSION | 10 | flags << 8 | bool(width) << 10 | variant << 11 | channel << 21
    return struct.pack("<IIIIq", place, 0x04030201, 9, ordinal, stamp) + packed_mask + body


def single(body=b"body", flags=0, mask=0x87, stamp=STAMP):
    packed_mask, width = mask_bytes(mask)
    return header(12, flags=flags | width) + struct.pack("<q", stamp) + packed_mask + body


def following(body=b"more", offset=1440, variant=3, writer=0x04030201):
    return struct.pack("<BBII", VERSION | 2, variant, writer, 9) + struct.pack("<I", offset)[:3] + body


def far(body=b"more", offset=1 << 24):
    return header(13) + struct.pack("<I", offset) + body


def heartbeat(begin=4, end=9):
    return header(3, at_2=5000) + struct.pack("<IQQ", 0, begin, end)


def ack(parts, following_ordinal=6):
    data = b"".join(struct.pack("<III", *part) for part in parts)
    return header(4, at_2=len(parts)) + struct.pack("<IQ", 0, following_ordinal) + data


def mark(position=1 << 33):
    return header(8, at_2=5000, at_8=position % 2**32) + struct.pack("<IIIQQ", position >> 32, 0, 70, 0, 12345)


def report(position=1 << 33, window=1 << 20):
    body = struct.pack("<IIIIIQ", position >> 32, window, 70, 69, 1472, 12345)
    return header(9, at_2=0, at_8=position % 2**32) + body


def packed(bodies, each, flags=0, marks=b"", padding=b""):
    data = b"".join((b"" if each else struct.pack("<H", len(body))) + body for body in bodies)
    packed_mask, width = mask_bytes(0x3)
    counts = struct.pack("<HHq", len(bodies), each, STAMP)
    return header(5, flags=flags | width) + counts + packed_mask + marks + data + padding


def group_offer(address=0xEFFF1002, ahead=-5):
    return header(6, at_2=5000, at_8=2) + struct.pack("<IIIq", 1, address, 4, ahead)


def group_report(heard=70):
    return header(7, at_2=0, at_8=2) + struct.pack("<IQ", 1, heard)


def group_probe(ordinal=70):
    return header(11, at_2=0, at_8=2) + struct.pack("<IQ", 0, ordinal)


def rate(period=100_000, ordinal=7):
    return struct.pack("<II", period, ordinal)


def history(reader=0x1_0000_0002, oldest=5):
    return struct.pack("<QQ", reader, oldest)


def channel(ordinal=12):
    return struct.pack("<IIQ", 1, 0, ordinal)


def group(ordinal=12):
    return struct.pack("<IIQ", 2, 0, ordinal)
