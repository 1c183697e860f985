"""Systems of particles: what a script records for them, and what it reads from them."""
