"""Starting jobs on many ranks, and watching over them, from a process that is no rank."""
