"""How it works: motion, engagement, cutting, structure, surface. Plain SI numbers in, plain SI numbers out."""
