import pytest

from knotfem.scene import Scene, load_scene


@pytest.fixture(scope="session")
def scene() -> Scene:
    return load_scene("bowline")
