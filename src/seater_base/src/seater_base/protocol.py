"""Lines of text between computer and microcontroller (docs/how-to/connect_a_base.md).

    V <sequence> <v mm/s> <omega mrad/s> <power 0|1>*<crc>       to the base
    J <sequence> <drive mV> <turn mV> <power 0|1>*<crc>          to a base with a joystick's input, in place of V
    O <clock ms> <left counts> <right counts> <flags>*<crc>      from the base
    I <protocol> <name>*<crc>                                    from the base when it starts, or asked by ?*<crc>

Protocol 2 has J, and the flags CONTACT and CHARGING; all else is as in protocol 1.

Each ends with a line feed. Whole numbers in decimal; clock and sequence 32 bits without, counts 32 bits with sign, all
wrap. crc: CRC-16/CCITT-FALSE of what stands before the star, as four hexadecimal digits. What does not fit is ignored.
"""

from __future__ import annotations

import binascii
import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntFlag

VERSION = 2
SPOKEN = (1, 2)  # of bases that can be driven; with 1 there is neither J nor a word about charging
LONGEST = 80  # bytes of a line
_COMMAND = re.compile(r"V (\d{1,10}) (-?\d{1,6}) (-?\d{1,6}) ([01])")
_DEFLECTION = re.compile(r"J (\d{1,10}) (\d{1,5}) (\d{1,5}) ([01])")
_ODOMETRY = re.compile(r"O (\d{1,10}) (-?\d{1,10}) (-?\d{1,10}) (\d{1,5})")
_IDENTITY = re.compile(r"I (\d{1,5}) (\S{1,40})")
ASK = "?"


class Flags(IntFlag):
    """State of the base."""

    POWER = 1  # the motors have power
    SILENT = 2  # stopped, as no command has come for 0.3 s
    FAULT = 4  # of a motor or its driver
    EMERGENCY_STOP = 8  # a button of the base is pressed
    CONTACT = 16  # the charger's voltage is at the contacts
    CHARGING = 32  # its current flows


@dataclass(frozen=True)
class Command:
    """To the base."""

    sequence: int
    v: float  # [m/s]
    omega: float  # [rad/s]
    power: bool

    def text(self) -> str:
        """Without checksum. Raises ValueError: not finite."""
        return f"V {self.sequence} {round(1e3 * self.v)} {round(1e3 * self.omega)} {int(self.power)}"


@dataclass(frozen=True)
class Deflection:
    """To a base that drives by a joystick's voltages."""

    sequence: int
    drive: float  # [V]
    turn: float  # [V]
    power: bool

    def text(self) -> str:
        """Without checksum. Raises ValueError: not finite."""
        return f"J {self.sequence} {round(1e3 * self.drive)} {round(1e3 * self.turn)} {int(self.power)}"


@dataclass(frozen=True)
class Reading:
    """From the base."""

    clock: int  # [ms]
    left: int  # counts
    right: int
    flags: Flags

    def text(self) -> str:
        """Without checksum."""
        return f"O {self.clock} {self.left} {self.right} {int(self.flags)}"


@dataclass(frozen=True)
class Identity:
    """Who the base is."""

    version: int
    name: str

    def text(self) -> str:
        """Without checksum."""
        return f"I {self.version} {self.name}"


Message = Command | Deflection | Reading | Identity | str


def encode(text: str) -> bytes:
    """With checksum and line feed."""
    return f"{text}*{checksum(text.encode()):04X}\n".encode()


def checksum(data: bytes) -> int:
    """CRC-16/CCITT-FALSE: polynomial 0x1021, begins with 0xFFFF."""
    return binascii.crc_hqx(data, 0xFFFF)


def decode(line: bytes) -> Message | None:
    """Of a line without its line feed; None: not one of this protocol, or damaged."""
    text, star, crc = line.rstrip(b"\r").rpartition(b"*")
    if not star or not re.fullmatch(rb"[0-9A-F]{4}", crc) or int(crc, 16) != checksum(text):
        return None
    plain = text.decode("ascii", "replace")
    if found := _COMMAND.fullmatch(plain):
        return Command(int(found[1]), int(found[2]) / 1e3, int(found[3]) / 1e3, found[4] == "1")
    if found := _DEFLECTION.fullmatch(plain):
        return Deflection(int(found[1]), int(found[2]) / 1e3, int(found[3]) / 1e3, found[4] == "1")
    if found := _ODOMETRY.fullmatch(plain):
        return Reading(int(found[1]), int(found[2]), int(found[3]), Flags(int(found[4])))
    if found := _IDENTITY.fullmatch(plain):
        return Identity(int(found[1]), found[2])
    return ASK if plain == ASK else None


class Lines:
    """Bytes in pieces, messages out."""

    def __init__(self) -> None:
        self._rest = b""
        self.damaged = 0  # lines

    def feed(self, data: bytes) -> Iterator[Message]:
        """The messages that end in `data`."""
        *whole, rest = (self._rest + data).split(b"\n")
        self._rest = rest if len(rest) <= LONGEST else b""  # noise without line feeds does not pile up
        for line in whole:
            message = decode(line) if len(line) <= LONGEST else None
            if message is None:
                self.damaged += 1
            else:
                yield message
