"""The commands of ``urdf-ik``, one file each.

A file's docstring is the help text of its command, its function ``command`` is the work, and the parameters of that
function are the arguments and options. Every command file is imported for ``urdf-ik --help``, so that a file imports
numpy, rich and the rooms of this package inside its functions.
"""

COMMANDS = {
    "robots": "robots",
    "doctor": "doctor",
    "info": "info",
    "fk": "fk",
    "ik": "ik",
    "check": "check",
    "compare": "compare",
    "freeze": "freeze",
    "compile": "compile",
    "verify": "verify",
    "judge": "judge",
    "dh": "dh",
    "path": "path",
    "plot": "show.plot",
    "view": "show.view",
    "workspace": "maps.workspace",
    "placement": "maps.placement",
    "dataset": "maps.dataset",
}
"""The file of each command, in the order of ``urdf-ik --help``."""
