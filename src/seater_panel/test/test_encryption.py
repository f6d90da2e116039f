"""With a certificate nobody in the network can read the token."""

import asyncio
import ssl
import subprocess
from pathlib import Path

import aiohttp
import pytest
from panels import Client, FakePanel, until

from seater_panel.web.serve import CertificateError, encryption


def make_certificate(folder: Path, name: str) -> tuple[Path, Path]:
    certificate, key = folder / f"{name}.pem", folder / f"{name}.key"
    words = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    words += ["-subj", "/CN=chair", "-addext", "subjectAltName=IP:127.0.0.1", "-days", "2"]
    subprocess.run([*words, "-out", certificate, "-keyout", key], check=True, capture_output=True)
    return certificate, key


def test_a_page_holds_over_https_and_plain_http_gets_nothing(tmp_path: Path) -> None:
    certificate, key = make_certificate(tmp_path, "chair")
    connector = aiohttp.TCPConnector

    async def main() -> None:
        panel, trusted = FakePanel(2.0), ssl.create_default_context(cafile=str(certificate))
        async with (
            panel.served(encrypted=encryption(certificate, key)) as url,
            aiohttp.ClientSession(connector=connector(ssl=trusted)) as http,
        ):
            client = await Client.connect(http, url)
            await client.begin()
            await until(lambda: panel.chair.goal == "dock")
            await client.release()
            await until(lambda: not panel.chair.held)
            with pytest.raises(aiohttp.ClientError):
                await http.get(url.replace("https", "http"))
            foreign = {"Origin": url.replace("https", "http")}  # the same place without encryption is another one
            with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
                await http.ws_connect(f"{url}/socket", headers=foreign)

    asyncio.run(main())


def test_files_that_cannot_be_used_are_refused(tmp_path: Path) -> None:
    certificate, key = make_certificate(tmp_path, "chair")
    _, other = make_certificate(tmp_path, "other")
    locked = tmp_path / "locked"
    words = ["openssl", "ec", "-in", key, "-aes256", "-passout", "pass:secret", "-out", locked]
    subprocess.run(words, check=True, capture_output=True)
    pairs = ((certificate, other), (certificate, locked), (key, key), (certificate, tmp_path / "none"), (tmp_path, key))
    for wrong in pairs:
        with pytest.raises(CertificateError, match=str(wrong[0])) as error:
            encryption(*wrong)
        assert "_ssl.c" not in str(error.value) and "Errno" not in str(error.value)
