"""The controller as other programs use it: ten lines in docs/controller.md."""

from seater_nmpc.control.controller import DockingController

__all__ = ["DockingController"]
