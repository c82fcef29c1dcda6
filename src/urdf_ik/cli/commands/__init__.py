"""The commands of ``urdf-ik``, one file each.

A file's docstring is the help text of its command, its function ``command`` is the work, and the parameters of that
function are the arguments and options. Every command file is imported for ``urdf-ik --help``, so that a file imports
numpy, rich and the rooms of this package inside its functions.
"""

GROUPS = {
    "Ask an arm": {
        "ik": "ik",
        "fk": "fk",
        "info": "info",
        "explain": "explain",
        "dh": "dh",
        "workspace": "maps.workspace",
    },
    "Hold it to account": {
        "check": "check",
        "compare": "compare",
        "freeze": "freeze",
        "verify": "verify",
        "judge": "judge",
    },
    "Make something with it": {
        "path": "path",
        "calibrate": "fitted.calibrate",
        "placement": "maps.placement",
        "compile": "outside.compile",
        "export": "outside.export",
    },
    "Show": {
        "view": "show.view",
        "plot": "show.plot",
        "robots": "robots",
        "doctor": "doctor",
    },
}
"""The commands in the groups of ``urdf-ik --help``, each with its file; at most six in a group."""

COMMANDS = {name: file for group in GROUPS.values() for name, file in group.items()}
"""The file of each command."""
