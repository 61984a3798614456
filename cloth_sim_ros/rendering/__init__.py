"""Drawing scenes without a display, on VTK: pictures and animations for documents, not a viewer.

``stage``, ``ground``, ``shapes`` and ``files`` need the extra ``[render]``; the others can be imported everywhere.
"""
