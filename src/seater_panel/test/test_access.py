"""Nobody without the token, and no foreign page."""

import os
import stat
from pathlib import Path

import pytest

from seater_panel.access.origin import host_allowed, origin_allowed
from seater_panel.access.token import TokenError, load_or_make, matches


def test_the_token_is_made_once_for_its_owner_alone(tmp_path: Path) -> None:
    file = tmp_path / "state" / "token"
    old = os.umask(0)
    try:
        token = load_or_make(file)
    finally:
        os.umask(old)
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
    assert len(token) >= 32
    assert load_or_make(file) == token
    assert load_or_make(tmp_path / "other") != token


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660])
def test_a_token_that_others_can_read_is_refused(tmp_path: Path, mode: int) -> None:
    file = tmp_path / "token"
    load_or_make(file)
    file.chmod(mode)
    with pytest.raises(TokenError, match="others may read it"):
        load_or_make(file)


@pytest.mark.parametrize("text", ["", "short", "x" * 40 + "\x00", "ä" * 40])
def test_a_file_without_a_token_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "token"
    file.touch(mode=0o600)
    file.write_text(text)
    with pytest.raises(TokenError, match="holds no token"):
        load_or_make(file)


@pytest.mark.parametrize("given", [None, "", 7, "secret-secret-secret ", "secret-secret-secre", "\ud800", ["secret"]])
def test_wrong_tokens_do_not_match(given: object) -> None:
    assert not matches(given, "secret-secret-secret")


def test_the_right_token_matches() -> None:
    assert matches("secret-secret-secret", "secret-secret-secret")


@pytest.mark.parametrize(
    ("host", "local", "allowed"),
    [
        ("127.0.0.1:8480", "127.0.0.1", True),
        ("localhost:8480", "127.0.0.1", True),
        ("LOCALHOST", "::1", True),
        ("[::1]:8480", "::1", True),
        ("192.168.7.20:8480", "192.168.7.20", True),
        ("192.168.7.20:8480", "::ffff:192.168.7.20", True),
        ("chair.local:8480", "192.168.7.20", True),
        ("evil.example:8480", "127.0.0.1", False),  # DNS rebinding
        ("evil.example", "192.168.7.20", False),
        ("localhost:8480", "192.168.7.20", False),
        ("192.168.7.21:8480", "192.168.7.20", False),
        ("127.0.0.1.evil.example", "127.0.0.1", False),
        ("", "127.0.0.1", False),
        ("127.0.0.1", "", False),
    ],
)
def test_hosts(host: str, local: str, allowed: bool) -> None:
    assert host_allowed(host, local, {"chair.local"}) is allowed


@pytest.mark.parametrize(
    ("origin", "required", "allowed"),
    [
        ("http://127.0.0.1:8480", True, True),
        (None, False, True),
        (None, True, False),
        ("null", False, False),
        ("http://evil.example", False, False),
        ("http://127.0.0.1:9999", False, False),
        ("https://127.0.0.1:8480", False, False),
    ],
)
def test_origins(origin: str | None, required: bool, allowed: bool) -> None:
    assert origin_allowed(origin, "http", "127.0.0.1:8480", required=required) is allowed
