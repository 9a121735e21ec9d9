"""Readers of data sets: each module has recordings(folder, spec), which yields a Recording for each grasp, without its truth."""
