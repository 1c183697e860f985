"""A run that is seen and steered in browsers, and the record of it that replays."""
