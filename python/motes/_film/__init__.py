"""A film as a file while it grows: seconds encoded one by one, and what a killed run left of them."""
