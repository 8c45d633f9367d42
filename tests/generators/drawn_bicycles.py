"""Parameters of randomly drawn bicycles: other proportions, or missing masses and lengths."""

OTHER_PARAMETERS = [
    {"c": "-0.05"}, {"lam": "0"}, {"lam": "-pi/20"}, {"lam": "2*pi/5"}, {"w": "10"},
    {"rR": "0.01", "rF": "0.01"}, {"zB": "-5"}, {"zB": "-0.05", "xB": "-0.2"}, {"g": "0"},
    {"IRyy": "0", "IFyy": "0"},
]  # fmt: skip
