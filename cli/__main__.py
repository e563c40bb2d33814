"""So that `python -m knotfem_cli` is `knotfem`."""

from knotfem_cli.main import main

if __name__ == "__main__":
    main()
