"""What accuracy costs in time: ladders of runs, their limits and errors, and the settings that follow from them."""
