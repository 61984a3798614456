"""Columns of ``ClothMesh.spring_weight``: what a spring's stiffness is made of."""

WARP, WEFT, SHEAR, GIVEN = range(4)
