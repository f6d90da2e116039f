"""Routes of the panel: the page for everybody who may reach this address, images and the WebSocket with the token."""

from __future__ import annotations

import asyncio
import itertools
import json
from collections.abc import Awaitable, Callable, Iterable
from pathlib import Path

from aiohttp import WSMsgType, web

from seater_panel.access.origin import host_allowed, origin_allowed
from seater_panel.access.token import matches
from seater_panel.web.panel import Panel
from seater_panel.web.session import Session

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

FILES = {
    "/": ("index.html", "text/html"),
    "/panel.css": ("panel.css", "text/css"),
    "/panel.js": ("panel.js", "text/javascript"),
    "/link.js": ("link.js", "text/javascript"),
    "/buttons.js": ("buttons.js", "text/javascript"),
    "/doctor.js": ("doctor.js", "text/javascript"),
    "/scene.js": ("scene.js", "text/javascript"),
    "/icon.svg": ("icon.svg", "image/svg+xml"),
}
HEADERS = {
    # Only what comes from here runs, and no foreign page shows this one in a frame.
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
    "connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
}
MOST_PAGES = 8
IMAGE_PATIENCE = 2.0  # [s]
TOKEN_PATIENCE = 3.0  # [s] for the first message of a page
LONGEST_MESSAGE = 1024  # bytes
_NO_TOKEN = "the token is wrong or missing\n"
WRONG_TOKEN = 4401  # close codes of the WebSocket, after HTTP's 401 and 503
TOO_MANY = 4503


class Server:
    """`page`: folder of the page's files. `names`: under which, beside its address, the server may be called."""

    def __init__(self, panel: Panel, token: str, page: Path, names: Iterable[str]) -> None:
        self._panel, self._token, self._names = panel, token, set(names)
        self._files = {path: ((page / name).read_bytes(), kind) for path, (name, kind) in FILES.items()}
        self._clients = itertools.count(1)
        self._open: set[web.WebSocketResponse] = set()

    def application(self) -> web.Application:
        """What aiohttp serves."""
        application = web.Application(middlewares=[self._guard])
        for path in FILES:
            application.router.add_get(path, self._file)
        application.router.add_get("/image", self._image)
        application.router.add_post("/doctor", self._doctor)
        application.router.add_get("/socket", self._socket)
        application.on_startup.append(self._attach)
        application.on_shutdown.append(self._close)
        return application

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Host and Origin of each request, headers of each answer."""
        local = request.transport.get_extra_info("sockname") if request.transport else None
        socket = request.path == "/socket"
        if not host_allowed(request.host, str(local[0]) if local else "", self._names):
            answer: web.StreamResponse = web.Response(status=403, text="this address is not known here, see --host\n")
        elif not origin_allowed(request.headers.get("Origin"), request.scheme, request.host, required=socket):
            answer = web.Response(status=403, text="only the panel's own page may ask\n")
        else:
            try:
                answer = await handler(request)
            except web.HTTPException as error:
                answer = web.Response(status=error.status, text=f"{error.reason}\n")
        if not answer.prepared:
            answer.headers.update(HEADERS)
        return answer

    async def _file(self, request: web.Request) -> web.Response:
        content, kind = self._files[request.path]
        return web.Response(body=content, content_type=kind, charset="utf-8")

    def _authorised(self, request: web.Request) -> bool:
        scheme, _, token = request.headers.get("Authorization", "").partition(" ")
        return scheme == "Bearer" and matches(token, self._token)

    async def _doctor(self, request: web.Request) -> web.Response:
        if not self._authorised(request):
            return web.Response(status=401, text=_NO_TOKEN)
        if self._panel.check is None:
            return web.Response(status=404, text="the doctor cannot be asked here\n")
        if self._panel.view()["active"]:  # it needs a chair that stands, and time that the docking needs
            return web.Response(status=409, text="the chair drives: ask when it stands\n")
        return web.json_response(await self._panel.check.run())

    async def _image(self, request: web.Request) -> web.Response:
        if not self._authorised(request):
            return web.Response(status=401, text=_NO_TOKEN)
        after = request.query.get("after", "0")
        newer = await self._panel.frames.newer(int(after) if after.isdecimal() else 0, IMAGE_PATIENCE)
        if newer is None:
            return web.Response(status=204)
        number, jpeg = newer
        return web.Response(body=jpeg, content_type="image/jpeg", headers={"X-Frame-Number": str(number)})

    async def _socket(self, request: web.Request) -> web.WebSocketResponse:
        socket = web.WebSocketResponse(max_msg_size=LONGEST_MESSAGE, compress=False)
        await socket.prepare(request)
        self._open.add(socket)
        try:
            if len(self._open) > MOST_PAGES:
                await socket.close(code=TOO_MANY, message=b"too many pages")
            elif not await self._knows_the_token(socket):
                await socket.close(code=WRONG_TOKEN, message=b"the token is wrong")
            else:
                await Session(f"page {next(self._clients)}", socket, self._panel).run()
        finally:
            self._open.discard(socket)
        return socket

    async def _knows_the_token(self, socket: web.WebSocketResponse) -> bool:
        """The first message of a page: {"token": "..."}."""
        try:
            message = await socket.receive(timeout=TOKEN_PATIENCE)
            given = json.loads(message.data) if message.type is WSMsgType.TEXT else None
        except (TimeoutError, ValueError, RecursionError):
            return False
        return isinstance(given, dict) and matches(given.get("token"), self._token)

    async def _attach(self, _: web.Application) -> None:
        self._panel.frames.attach(asyncio.get_running_loop())

    async def _close(self, _: web.Application) -> None:
        for socket in list(self._open):
            await socket.close(code=1001, message=b"the panel ends")
