"""`motes.show` and `motes.launch`: runs in notebooks with a widget that shows and steers them."""
