"""The controller as other programs use it: ten lines in docs/tutorials/controller_in_ten_lines.md."""

from seater_nmpc.control.controller import DockingController

__all__ = ["DockingController"]
