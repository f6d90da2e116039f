import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--hardware",
        action="append",
        default=[],
        metavar="KIND:DEVICE",
        help="what is plugged in, and let go: joystick:/dev/input/event3, contact:gpiochip0:17 (closed)",
    )
