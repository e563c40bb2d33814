"""A study of many scenes: `study_file` is what the user asks for, `axes` and `plan` make the points of it, `collect`
reads what they came to, `table` holds the results, `run` brings all points to an outcome."""
