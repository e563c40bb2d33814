"""What the user asked for: read from TOML, validated, units resolved, frozen."""

from knotfem.scene.load import load_scene
from knotfem.scene.model import Scene
from knotfem.scene.write import scene_to_toml

__all__ = ["Scene", "load_scene", "scene_to_toml"]
