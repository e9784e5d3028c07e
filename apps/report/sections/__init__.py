"""What of an answer is shown: a topic a file, each made once and rendered everywhere."""
