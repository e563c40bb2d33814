"""Write a resolved scene as TOML, every default included."""

from __future__ import annotations

from knotfem.scene.model import Scene


def scene_to_toml(scene: Scene) -> str:
    """The scene as TOML text that `load_scene` reads as an identical scene."""
    import tomlkit

    tables = scene.model_dump(mode="json", exclude_none=True)
    tables["steps"] = [{"kind": step.pop("kind"), **step} for step in tables["steps"]]
    return tomlkit.dumps(tables)
