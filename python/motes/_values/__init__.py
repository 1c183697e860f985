"""What a script hands over: values that never change, checks of arguments, settings of a world's parts."""
