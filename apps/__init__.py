"""Whatever reads logs, prints, draws, talks or runs in parallel; hands values from room to room."""
