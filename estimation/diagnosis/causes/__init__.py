"""What most likely went wrong: wrong assumptions are undone one by one, and the fit is watched."""
