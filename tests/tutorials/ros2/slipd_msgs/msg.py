"""Messages by the package's own definitions (.msg), decoded by the rules of CDR (little endian, each number at a multiple of its size)."""
import os, pathlib, struct

NUMBERS = {"bool": "?", "uint8": "B", "int32": "i", "uint32": "I", "uint64": "Q", "float64": "d"}
OTHERS = {"std_msgs/Header": [("int32", "sec"), ("uint32", "nanosec"), ("string", "frame_id")]}


class Cdr:
    def __init__(self, payload):
        assert payload[:2] == b"\0\1", "plain CDR, little endian"
        self.bytes, self.at = payload[4:], 0

    def number(self, code):
        size = struct.calcsize(code)
        self.at += -self.at % size
        value, = struct.unpack_from("<" + code, self.bytes, self.at)
        self.at += size
        return value

    def value(self, kind):
        if kind == "string":
            length = self.number("I")
            text = self.bytes[self.at:self.at + length - 1].decode()
            self.at += length
            return text
        if kind in OTHERS:
            return {name: self.value(inner) for inner, name in OTHERS[kind]}
        return self.number(NUMBERS[kind])


def message(name):
    text = (pathlib.Path(os.environ["SLIPD_SOURCE_DIR"]) / f"bridges/ros2/slipd_msgs/msg/{name}.msg").read_text(encoding="utf-8")
    lines = [line.split("#")[0].split() for line in text.splitlines()]
    fields, constants = [], {"DDS_NAME": f"slipd_msgs::msg::dds_::{name}_"}
    for line in filter(None, lines):
        kind, named = line
        constant, _, value = named.partition("=")
        if value:
            constants[constant] = int(value)
        else:
            fields.append((kind, named))

    def of(payload):
        cdr, made = Cdr(payload), kind_of_message()
        for kind, field in fields:
            setattr(made, field, cdr.value(kind))
        return made

    kind_of_message = type(name, (), constants | {"of": staticmethod(of)})
    return kind_of_message


SlipEstimate = message("SlipEstimate")
