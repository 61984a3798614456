"""Building meshes: what is refused or mended, and how triangles and springs become stiffness, hinges and areas."""
