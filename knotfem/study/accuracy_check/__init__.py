"""Errors of a scene's own settings, measured by finer ones, and settings that bring them within a target."""
