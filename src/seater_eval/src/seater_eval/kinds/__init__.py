"""Markers as kinds of cameras deliver them, drawn at known poses: perception_kinds."""
