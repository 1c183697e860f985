"""Where ranks of `losing.py` may die: calls that pass something on, to other ranks or to the disk."""

FRAMES = 13

PLACES: dict[str, tuple[str, str, int]] = {
    "the frame": ("", "", FRAMES),
    "the run": ("motes._world.handshake.begin", "", 1),
    "the meeting": ("motes._world.handshake.meet", "", 1),
    "the frame's call": ("motes._world.running.Running._run", "", FRAMES),
    "the picture's note": ("motes._film.movie.Movie.write", "", FRAMES),
    "the saved picture": ("motes._picture.frame.Frame.save", "", FRAMES),
    "the frame's border": ("motes._checkpoint.resuming.Checkpoints.at_border", "", FRAMES),
    "securing the film": ("motes._film.writing.FilmWriter.secure", "", 3),
    "a segment": ("motes._film.growing.GrowingFilm.append", "draws", 5),
    "showing the film": ("motes._film.growing.GrowingFilm._show", "draws", 1),
    "the film's sync": ("motes._film.growing.GrowingFilm.sync", "draws", 3),
    "the film's name": ("motes._film.growing.GrowingFilm.finish", "draws", 1),
    "the film's close": ("motes._film.movie.Movie.close", "", 1),
    "taking over the film": ("motes._film.writing.FilmWriter.take_over", "manages", 1),
    "the checkpoint's begin": ("motes._checkpoint.saving.Saver.begin", "", 3),
    "the checkpoint's wait": ("motes._checkpoint.saving.Saver.finish", "", 4),
    "the checkpoint's report": ("motes._checkpoint.saving.Saver._post", "", 3),
    "the checkpoint's manifest": ("motes._checkpoint.saving.Saver._make_whole", "manages", 3),
    "the checkpoint's name": ("motes._checkpoint.folder.finish", "manages", 3),
    "the last checkpoint": ("motes._checkpoint.resuming.Checkpoints.save_now", "", 1),
    "the recovery": ("motes._world.recovering.Recovery.regroup", "", 1),
    "the way back": ("motes._world.recovering.Recovery.resumed", "", 1),
    "the export": ("motes._interchange.export.Export.write", "", FRAMES),
    "the export's end": ("motes._interchange.export.Export.close", "", 1),
    "the world's end": ("motes._world.running.Running.end", "", 1),
    "the world's leave": ("motes._world.running.Running._leave", "", 1),
}
"""By name: the function, which ranks call it ("": any), and how often in a world."""
