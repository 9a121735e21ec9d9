"""Bytes of DDS messages by the rules of CDR alone (XCDR version 1, OMG XTypes 1.3, 7.4): each number at a multiple of its size."""
import struct


class CdrWriter:
    """Little-endian unless it is said."""

    def __init__(self, big=False):
        self.bytes, self.order = bytearray(), ">" if big else "<"

    def put(self, code, *values):
        size = struct.calcsize(code)
        for value in values:
            self.bytes += bytes(-len(self.bytes) % size) + struct.pack(self.order + code, value)
        return self

    def text(self, text):
        self.put("I", len(text) + 1)
        self.bytes += text.encode() + b"\0"
        return self

    def blob(self, data):
        self.put("I", len(data))
        self.bytes += data
        return self

    def header(self, stamp_s, frame_id="finger"):
        return self.put("i", int(stamp_s)).put("I", int(stamp_s % 1 * 1e9)).text(frame_id)

    def message(self):
        return (b"\0\0\0\0" if self.order == ">" else b"\0\1\0\0") + bytes(self.bytes)


class CdrReader:
    """Little-endian. `body`: what follows the header of four bytes; `at`: where to begin."""

    def __init__(self, body, at=0):
        self.body, self.at = body, at

    def number(self, code):
        size = struct.calcsize(code)
        self.at += -self.at % size
        value, = struct.unpack_from("<" + code, self.body, self.at)
        self.at += size
        return value

    def text(self):
        length = self.number("I")
        text = self.body[self.at:self.at + length - 1].decode()
        self.at += length
        return text
