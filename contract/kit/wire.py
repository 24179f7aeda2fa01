"""The messages of `proto/fleet.proto`, made from that file when the kit starts.

The part of the language that the file uses is small: messages of plain fields, no nesting, no options. So no compiler is needed,
and nothing generated can be older than the file. What is not understood is an error: nothing is left out in silence.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import DecodeError, Message

PROTO = Path(__file__).resolve().parent.parent / "proto" / "fleet.proto"
Field = descriptor_pb2.FieldDescriptorProto

FIELD = re.compile(r"(repeated\s+)?(\w+)\s+(\w+)\s*=\s*(\d+)\s*;")
MESSAGE = re.compile(r"message\s+(\w+)\s*\{([^{}]*)\}")
HEAD = re.compile(r'\s*syntax\s*=\s*"proto3"\s*;\s*package\s+([\w.]+)\s*;')


def describe(text: str) -> descriptor_pb2.FileDescriptorProto:
    """The description of a .proto file in the small language above. Raises ValueError where it is more than that."""
    text = re.sub(r"//[^\n]*", "", text)
    head = HEAD.match(text)
    if head is None:
        raise ValueError("expected `syntax = \"proto3\"` and a package at the top of the .proto file")
    package = head.group(1)
    file = descriptor_pb2.FileDescriptorProto(name="fleet.proto", package=package, syntax="proto3")
    body = text[head.end():]
    if MESSAGE.sub("", body).strip():
        raise ValueError(f"not understood in the .proto file: {MESSAGE.sub('', body).split()[:8]}")
    names = [found.group(1) for found in MESSAGE.finditer(body)]
    for found in MESSAGE.finditer(body):
        message = file.message_type.add(name=found.group(1))
        if FIELD.sub("", found.group(2)).strip():
            raise ValueError(f"not understood in message {message.name}: {FIELD.sub('', found.group(2)).split()}")
        for repeated, kind, name, number in FIELD.findall(found.group(2)):
            label = Field.LABEL_REPEATED if repeated else Field.LABEL_OPTIONAL
            field = message.field.add(name=name, number=int(number), label=label)
            if kind in names:
                field.type, field.type_name = Field.TYPE_MESSAGE, f".{package}.{kind}"
            else:
                field.type = Field.Type.Value(f"TYPE_{kind.upper()}")
    return file


_file = describe(PROTO.read_text(encoding="utf-8"))
_pool = descriptor_pool.DescriptorPool()
_pool.Add(_file)


def _class(name: str) -> Any:
    return message_factory.GetMessageClass(_pool.FindMessageTypeByName(f"{_file.package}.{name}"))


Version = _class("Version")
Pose = _class("Pose")
Level = _class("Level")
RobotState = _class("RobotState")
RobotReport = _class("RobotReport")
FloorArea = _class("FloorArea")
Access = _class("Access")
Control = _class("Control")
ControlFlag = _class("ControlFlag")
ControlPath = _class("ControlPath")
Instruction = _class("Instruction")
MediatorReport = _class("MediatorReport")
AccessGrant = _class("AccessGrant")
TakeUp = _class("TakeUp")
CertificateRequest = _class("CertificateRequest")
CertificateAnswer = _class("CertificateAnswer")

LONGEST_MESSAGE = 1 << 20


def decode(kind: Any, data: bytes) -> Message | None:
    """The message, or None where the bytes are none or too many."""
    if len(data) > LONGEST_MESSAGE:
        return None
    try:
        return kind.FromString(data)
    except DecodeError:
        return None


def unknown_field(number: int, length: int = 3) -> bytes:
    """Bytes of a field that the .proto does not have, as a later minor version may send it. Append it to a message."""
    def varint(value: int) -> bytes:
        out = bytearray()
        while value > 0x7F:
            out.append(value & 0x7F | 0x80)
            value >>= 7
        out.append(value)
        return bytes(out)

    return varint(number << 3 | 2) + varint(length) + b"x" * length
