"""Makes `specimens`, the small models that several test folders share, importable whatever the import mode."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
