"""Whatever reads logs, prints, draws, talks or runs in parallel; hands values from room to room.

What cannot be used or written is refused by an ``InputError``, whose one line says what, where and what to do.
"""
