#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Fails if a folder of panoptic/ includes one that panoptic/LAYERS does not allow it. Usage: check_layers.py [ROOT]"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
lines = [line for line in (root / "panoptic/LAYERS").read_text().splitlines() if line and not line.startswith("#")]
allowed = {name.strip(): set(below.split()) for name, below in (line.split(":") for line in lines)}
errors = []
for path in sorted((root / "panoptic").glob("*/*")):
    folder = path.parent.name
    if path.suffix not in (".h", ".cpp"):
        continue
    if folder not in allowed:
        errors.append(f"{path}: the folder '{folder}' is not in panoptic/LAYERS")
        continue
    for number, line in enumerate(path.read_text().splitlines(), 1):
        include = re.match(r'\s*#\s*include\s*["<]([^">]+)[">]', line)
        if not include or ('"' not in line and not include[1].startswith("panoptic/")):
            continue
        parts = include[1].split("/")
        if parts[0] != "panoptic" or len(parts) != 3:
            errors.append(f'{path}:{number}: write "panoptic/<folder>/<file>", not "{include[1]}"')
        elif parts[1] != folder and parts[1] not in allowed[folder]:
            errors.append(f"{path}:{number}: '{folder}' may not include '{parts[1]}' (panoptic/LAYERS)")
print("\n".join(errors) or f"layers: {len(allowed)} folders, no findings", file=sys.stderr if errors else sys.stdout)
sys.exit(1 if errors else 0)
