"""One engine for everything that runs many scenes: run directories are brought to their goals by workers of dask.

`outcomes` says what became of a run, `orders` what a worker is told and answers, `execute` runs in the worker,
`places` tells where workers are, `engine` hands runs out and yields them as they end.
"""
