"""The web server in a thread of its own."""

from __future__ import annotations

import asyncio
import ssl
import threading
from pathlib import Path
from types import TracebackType

from aiohttp import web

from seater_common.params import why

STARTS_WITHIN = 10.0  # [s]


class CertificateError(ValueError):
    """The files of certificate and key cannot be used."""


def encryption(certificate: Path, key: Path) -> ssl.SSLContext:
    """TLS with these files (PEM; `certificate`: with the chain up to its root, if it has one).

    Raises:
        CertificateError: one cannot be read, or they do not belong together.
    """
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    try:
        context.load_cert_chain(certificate, key, password="")  # a locked key is refused, not asked for
    except ssl.SSLError as error:
        # Its own words name a line of the library's source.
        cause = (error.reason or "cannot be read").lower().replace("_", " ")
        text = f"must be a certificate and its key, in PEM and without a password ({cause})"
        raise CertificateError(f"{certificate}, {key}: {text}") from error
    except OSError as error:
        raise CertificateError(f"{certificate}, {key}: {why(error)}") from error
    return context


class Serving:
    """`with Serving(application, address, port) as serving:` - the port is open inside, and closed after it.

    Raises OSError: the address or port cannot be had.
    """

    def __init__(
        self, application: web.Application, address: str, port: int, encrypted: ssl.SSLContext | None = None
    ) -> None:
        """`port` 0: any that is free, see `port`. `encrypted` None: plain HTTP."""
        self._application, self._address, self.port = application, address, port
        self._encrypted = encrypted
        self._loop = asyncio.new_event_loop()
        self._runner: web.AppRunner | None = None
        self._thread = threading.Thread(target=self._loop.run_forever, name="web", daemon=True)

    def __enter__(self) -> Serving:
        self._thread.start()
        try:
            asyncio.run_coroutine_threadsafe(self._start(), self._loop).result(STARTS_WITHIN)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    async def _start(self) -> None:
        self._runner = web.AppRunner(self._application, access_log=None)
        await self._runner.setup()
        site = web.TCPSite(self._runner, self._address, self.port, shutdown_timeout=1.0, ssl_context=self._encrypted)
        await site.start()
        self.port = self._runner.addresses[0][1]

    async def _finish(self) -> None:
        if self._runner is not None:
            await self._runner.cleanup()
        waiting = asyncio.all_tasks() - {asyncio.current_task()}  # for images, most of all
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)

    def _end(self) -> None:
        asyncio.run_coroutine_threadsafe(self._finish(), self._loop).result(STARTS_WITHIN)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(STARTS_WITHIN)
