# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""What is known of a place: the numbers in FloorGrids and FreeSpace."""
UNKNOWN, FREE, OCCUPIED = 0, 1, 2
