"""Messages by the package's own definitions (.msg), decoded from CDR."""
import os, pathlib

from cdr import CdrReader

NUMBERS = {"bool": "?", "uint8": "B", "int32": "i", "uint32": "I", "uint64": "Q", "float64": "d"}
OTHERS = {"std_msgs/Header": [("int32", "sec"), ("uint32", "nanosec"), ("string", "frame_id")]}


def value(cdr, kind):
    if kind == "string":
        return cdr.text()
    if kind in OTHERS:
        return {name: value(cdr, inner) for inner, name in OTHERS[kind]}
    return cdr.number(NUMBERS[kind])


def message(name):
    text = (pathlib.Path(os.environ["SLIPD_SOURCE_DIR"]) / f"bridges/ros2/slipd_msgs/msg/{name}.msg").read_text(encoding="utf-8")
    lines = [line.split("#")[0].split() for line in text.splitlines()]
    fields, constants = [], {"DDS_NAME": f"slipd_msgs::msg::dds_::{name}_"}
    for line in filter(None, lines):
        kind, named = line
        constant, _, number = named.partition("=")
        if number:
            constants[constant] = int(number)
        else:
            fields.append((kind, named))

    def of(payload):
        assert payload[:2] == b"\0\1", "plain CDR, little-endian"
        cdr, made = CdrReader(payload[4:]), kind_of_message()
        for kind, field in fields:
            setattr(made, field, value(cdr, kind))
        return made

    kind_of_message = type(name, (), constants | {"of": staticmethod(of)})
    return kind_of_message


SlipEstimate = message("SlipEstimate")
