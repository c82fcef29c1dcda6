"""The commands of ``urdf-ik``: one function each, whose docstring is its help and whose parameters are its options.

``urdf-ik --help`` imports none of these files. A command loads an arm, calls a function of the package and prints.
"""

GROUPS = {
    "Ask an arm": {
        "ik": ("ik", "Inverse kinematics: every solution of a pose, with its branch, checks and error"),
        "fk": ("kinematics", "Forward kinematics: the tip's pose in the base, for each joint vector"),
        "info": ("info", "Show an arm: its joints, how neighbouring axes lie to each other, and how it is solved"),
        "explain": ("explain", "Explain the answer to a pose: what stands in the way of each solution"),
        "dh": ("kinematics", "Denavit-Hartenberg table of an arm, or an arm from a table (CSV or JSON)"),
        "workspace": ("regions", "The region that the tip reaches: exact for a planar arm, a map for any other"),
    },
    "Hold it to account": {
        "check": ("checks", "Check an arm against Pinocchio: kinematics, every solution of random poses, collision"),
        "compare": ("checks", "Compare arms, or URDFs of one arm (another tool, a calibrated copy)"),
        "freeze": ("locks", "Freeze an arm: write its answers of today to a lock file for version control"),
        "verify": ("locks", "Verify an arm against its lock file"),
        "judge": ("checks", "Judge another solver on an arm: the solutions that it has wrong, misses or doubles"),
    },
    "Make something with it": {
        "path": ("path", "Follow a path: the cheapest joint motion through all waypoints"),
        "calibrate": (
            "calibrate",
            "Calibrate an arm: fit its URDF to measurements, or take over a vendor's",
        ),
        "placement": ("regions", "Find where to put the base: every position of a grid, in every heading, with scores"),
        "compile": ("exports", "Compile an arm: write the JSON file from which C++, C and Python solve it"),
        "export": ("exports", "Export an arm to one file: a header for C++ or C, or a page that needs no server"),
    },
    "Show": {
        "view": ("pictures", "Show an arm in the browser: every solution of a target to drag, sliders for the joints"),
        "plot": ("pictures", "Draw an arm, the branches of a pose, joint limits, the workspace or a path"),
        "robots": ("installation", "List the arms that have names, with the family and the joints of those here"),
        "doctor": ("installation", "Say what is installed and whether it works"),
    },
}
"""The commands in the groups of ``urdf-ik --help``, each with its file and a line on it."""

COMMANDS = {name: command for group in GROUPS.values() for name, command in group.items()}
"""The file and the line of each command."""
