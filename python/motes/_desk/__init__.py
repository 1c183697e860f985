"""The desk: a page that outlives the runs it shows, keeps their pictures, restarts and reloads them."""
