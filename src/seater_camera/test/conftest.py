import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--hardware",
        metavar="KIND[:DEVICE]",
        help="run test_contract.py on a camera that is plugged in: v4l2:/dev/video0, realsense",
    )
