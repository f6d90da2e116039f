"""The lines: what goes out comes in, and what is damaged is nothing."""

import numpy as np
import pytest

from seater_base.protocol import (
    ASK,
    LONGEST,
    Command,
    Deflection,
    Flags,
    Identity,
    Lines,
    Reading,
    checksum,
    decode,
    encode,
)


def test_the_checksum_is_that_of_the_standard() -> None:
    assert checksum(b"123456789") == 0x29B1


def test_lines_as_the_page_shows_them() -> None:
    assert encode(Command(7, 0.15, -0.2, True).text()) == b"V 7 150 -200 1*%04X\n" % checksum(b"V 7 150 -200 1")
    assert decode(b"O 1234 -20 30 3*%04X" % checksum(b"O 1234 -20 30 3")) == Reading(
        1234, -20, 30, Flags.POWER | Flags.SILENT
    )


@pytest.mark.parametrize(
    "message",
    [
        Command(2**32 - 1, -0.6, 0.8, False),
        Deflection(7, 2.5, 0.001, True),
        Reading(0, -(2**31), 2**31 - 1, Flags.FAULT | Flags.CHARGING),
        Identity(1, "a-b"),
    ],
)
def test_there_and_back(message) -> None:
    assert decode(encode(message.text()).rstrip(b"\n")) == message


def test_pieces_noise_and_line_ends() -> None:
    lines = Lines()
    stream = b"\xff\x00garbage\n" + encode(ASK) + encode("I 1 x").replace(b"\n", b"\r\n") + b"x" * 500
    found = [message for i in range(0, len(stream), 7) for message in lines.feed(stream[i : i + 7])]
    assert found == [ASK, Identity(1, "x")]
    assert lines.damaged == 1
    assert len(lines._rest) <= LONGEST
    assert list(lines.feed(b"\n" + encode(ASK))) == [ASK]


def test_no_damaged_line_is_taken_for_a_good_one() -> None:
    """One to three flipped bits of every line: the checksum finds all of them."""
    random = np.random.default_rng(3)
    for _ in range(5000):
        good = encode(Command(int(random.integers(1e6)), random.uniform(-1, 1), random.uniform(-1, 1), True).text())
        bad = bytearray(good.rstrip(b"\n"))
        for bit in random.choice(8 * len(bad), random.integers(1, 4), replace=False):
            bad[bit // 8] ^= 1 << (bit % 8)
        assert decode(bytes(bad)) is None, (good, bytes(bad))


@pytest.mark.parametrize(
    "text", ["V 1 nan 0 1", "V 1 2 3 2", "V 1 2 3", "O 1 2 3", "", "V 1 99999999 0 1", "J 1 -5 0 1", "W 1"]
)
def test_what_is_no_message(text: str) -> None:
    assert decode(encode(text).rstrip(b"\n")) is None
