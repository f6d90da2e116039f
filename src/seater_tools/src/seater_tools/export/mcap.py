"""A bag as MCAP (https://mcap.dev), profile ros1: every message byte for byte, with its definition."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from seater_common.bags import Raw, open_bag
from seater_tools.export.errors import ExportError
from seater_tools.export.tables import MISSING, check_new, choose

_KEPT = ("callerid", "latching", "md5sum")  # of a connection, as metadata of its channel


def export_mcap(bag: Path, path: Path, topics: Sequence[str], *, force: bool) -> dict[Path, int]:
    """The file and its number of messages. `topics`: only these; empty: all.

    Raises ExportError, and OSError: it cannot be written.
    """
    try:
        library: Any = importlib.import_module("mcap.writer")
    except ImportError as error:
        raise ExportError(MISSING.format("mcap", "mcap")) from error
    check_new(path, force)
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_name(f".{path.name}.half")
    try:
        with open_bag(bag, ExportError) as file, half.open("wb") as stream:
            wanted = choose(bag, list(file.topics), topics)
            writer = library.Writer(stream)
            writer.start(profile="ros1", library="seater")
            channels = _Channels(writer)
            count = 0
            for count, message in enumerate(file.raw(wanted), 1):
                time = message.time.to_nsec()
                writer.add_message(channels.of(message), time, message.data, time, count)
            writer.finish()
        half.replace(path)
    finally:
        half.unlink(missing_ok=True)
    return {path: count}


class _Channels:
    """One for each sender of a topic, one schema for each kind of message."""

    def __init__(self, writer: Any) -> None:
        self._writer = writer
        self._schemas: dict[tuple[str, str], int] = {}
        self._channels: dict[tuple[str, ...], int] = {}

    def of(self, message: Raw) -> int:
        """Its number."""
        about = {key: message.connection[key] for key in _KEPT if key in message.connection}
        key = (message.topic, message.kind, *(text for pair in sorted(about.items()) for text in pair))
        if key not in self._channels:
            self._channels[key] = self._writer.register_channel(
                topic=message.topic, message_encoding="ros1", schema_id=self._schema(message), metadata=about
            )
        return self._channels[key]

    def _schema(self, message: Raw) -> int:
        definition = message.connection["message_definition"]
        key = (message.kind, definition)
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                name=message.kind, encoding="ros1msg", data=definition.encode()
            )
        return self._schemas[key]
