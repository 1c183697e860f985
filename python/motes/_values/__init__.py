"""What a script passes: immutable values, checks of arguments, settings of a world's parts."""
