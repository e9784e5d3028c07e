"""The experiment of the paper, simulated: its tables and figures beside the printed ones."""
